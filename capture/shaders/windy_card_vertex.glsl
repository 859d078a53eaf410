// Cards with pictures of plants: strips of three pieces that bend with the wind, eight vertices each.
struct Card {
    vec4 base;   // middle of the lower edge; w: width
    vec4 shape;  // yaw, height, how far it bends (of its height), which column of the atlas
    vec4 tint;   // w: share of the sunlight that arrives
};
layout(std430, binding = 1) readonly buffer Cards { Card cards[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
uniform vec4 u_parameters[8];  // 1: the wind's direction, columns of the atlas
flat out uint v_instance;
flat out vec3 v_tint;
out vec2 v_texture;
out float v_light;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int index = gl_VertexID / 8;
    int corner = gl_VertexID - 8 * index;
    Card card = cards[index];
    float across = float(corner & 1);
    float up = float(corner / 2) / 3.0;
    float bend = card.shape.z * up * up;
    vec3 along = vec3(cos(card.shape.x), 0.0, sin(card.shape.x));
    vec3 place = card.base.xyz + card.base.w * (across - 0.5) * along;
    place += card.shape.y * ((up - 0.4 * bend * up) * vec3(0.0, 1.0, 0.0) + bend * u_parameters[1].xyz);
    v_tint = card.tint.rgb;
    v_texture = vec2((card.shape.w + across) / u_parameters[1].w, 1.0 - up);
    // Less light comes down to the foot.
    v_light = card.tint.a * (0.45 + 0.55 * up);
    gl_Position = u_projection * (u_view * vec4(place, 1.0));
}
