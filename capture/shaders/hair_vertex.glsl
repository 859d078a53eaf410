// Strands as ribbons that face the camera: two vertices a point, side by side.
layout(std430, binding = 1) readonly buffer Points { vec4 points[]; };    // position, light that arrives
layout(std430, binding = 2) readonly buffer Strands { vec4 strands[]; };  // colour, alpha
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
uniform vec4 u_parameters[8];  // 0: direction towards the light; 1: points a strand, half width in scene units
flat out uint v_instance;
flat out vec4 v_color;
out vec4 v_tangent;  // world space; w: light that arrives
out vec4 v_to_eye;   // world space; w: 0 at the root, 1 at the tip

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int count = int(u_parameters[1].x);
    int strand = gl_VertexID / (2 * count);
    int in_strand = gl_VertexID - strand * 2 * count;
    int point = in_strand / 2;
    float side = float(in_strand - 2 * point) * 2.0 - 1.0;
    int at = strand * count + point;
    vec4 here = points[at];
    vec3 before = points[point > 0 ? at - 1 : at].xyz;
    vec3 after = points[point + 1 < count ? at + 1 : at].xyz;
    vec3 tangent = normalize(after - before);
    vec3 eye = -(transpose(mat3(u_view)) * u_view[3].xyz);
    vec3 to_eye = eye - here.xyz;
    float along = float(point) / float(count - 1);
    // Strands thin out over their last third.
    float width = u_parameters[1].y * min(1.0, 3.3 * (1.0 - along) + 0.1);
    vec3 sideways = cross(to_eye, tangent);
    sideways /= max(length(sideways), 1e-6);
    v_tangent = vec4(tangent, here.w);
    v_to_eye = vec4(to_eye, along);
    v_color = strands[strand];
    gl_Position = u_projection * (u_view * vec4(here.xyz + sideways * (side * width), 1.0));
}
