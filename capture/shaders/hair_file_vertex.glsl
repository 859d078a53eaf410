// Strands of any lengths as ribbons that face the camera: two vertices a point, side by side.
struct Point {
    vec4 place;  // position; w: light that arrives, plus 2 at a strand's first point and 4 at its last
    vec4 look;   // colour as red * 65536 + green * 256 + blue, each 0 to 255; alpha; half width; unused
};
layout(std430, binding = 1) readonly buffer Points { Point points[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out vec4 v_color;
out vec4 v_tangent;  // world space; w: light that arrives
out vec4 v_to_eye;   // world space; w: 0, nothing fades towards a tip

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int at = gl_VertexID / 2;
    float side = float(gl_VertexID - 2 * at) * 2.0 - 1.0;
    Point here = points[at];
    int flags = int(here.place.w) / 2;
    vec3 before = points[flags == 1 ? at : at - 1].place.xyz;
    vec3 after = points[flags == 2 ? at : at + 1].place.xyz;
    vec3 along = after - before;
    vec3 tangent = along / max(length(along), 1e-6);
    vec3 eye = -(transpose(mat3(u_view)) * u_view[3].xyz);
    vec3 to_eye = eye - here.place.xyz;
    vec3 sideways = cross(to_eye, tangent);
    sideways /= max(length(sideways), 1e-6);
    int color = int(here.look.x);
    v_color = vec4(vec3(color / 65536, color / 256 % 256, color % 256) / 255.0, here.look.y);
    v_tangent = vec4(tangent, here.place.w - float(2 * flags));
    v_to_eye = vec4(to_eye, 0.0);
    gl_Position = u_projection * (u_view * vec4(here.place.xyz + sideways * (side * here.look.z), 1.0));
}
