// Textured rectangles in space, six vertices each, binding 1; follows daylight.glsl.
struct Card {
    vec4 centre;  // w: sunlight that arrives
    vec4 right;   // half the width; w: how often the texture repeats across
    vec4 up;      // half the height; w: how often it repeats upwards
    vec4 color;
};
layout(std430, binding = 1) readonly buffer Cards { Card cards[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out vec4 v_color;
out vec2 v_texture;
out vec3 v_light;
out float v_clear;  // of haze

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int corner = gl_VertexID % 6;
    Card card = cards[gl_VertexID / 6];
    bool right = corner == 1 || corner == 2 || corner == 4;
    bool top = corner == 2 || corner == 4 || corner == 5;
    vec2 side = vec2(right ? 1.0 : -1.0, top ? 1.0 : -1.0);
    // A negative number mirrors.
    v_texture.x = right == (card.right.w > 0.0) ? abs(card.right.w) : 0.0;
    v_texture.y = top ? 0.0 : card.up.w;
    vec3 from_centre = side.x * card.right.xyz + side.y * card.up.xyz;
    // Round things are lighter on the side of the sun.
    float turned = dot(from_centre, u_parameters[0].xyz) / length(card.up.xyz);
    float sun = card.centre.w * max(1.0 + u_parameters[4].x * turned, 0.0);
    v_light = u_parameters[2].rgb * sun + u_parameters[3].rgb;
    // The texture's coarse level would show a card seen edge-on as a grey streak.
    vec3 normal = normalize(cross(card.right.xyz, card.up.xyz));
    float facing = abs(dot(mat3(u_view) * normal, normalize((u_view * vec4(card.centre.xyz, 1.0)).xyz)));
    v_color = card.color;
    v_color.a *= mix(1.0, smoothstep(0.08, 0.35, facing), u_parameters[4].y);
    vec4 in_camera = u_view * vec4(card.centre.xyz + from_centre, 1.0);
    v_clear = exp(-u_parameters[1].w * length(in_camera.xyz));
    gl_Position = u_projection * in_camera;
}
