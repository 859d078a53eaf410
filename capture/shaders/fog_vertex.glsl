// Banks of fog as billboards that face the camera: six vertices a bank, two triangles.
layout(std430, binding = 1) readonly buffer Banks { vec4 banks[]; };  // two each, see fog_scene.cpp
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out float v_alpha;
out vec3 v_world;
out vec2 v_corner;  // -1 to 1 over the billboard
out vec2 v_texture;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int bank = gl_VertexID / 6;
    int corner = gl_VertexID - 6 * bank;
    vec4 place = banks[2 * bank];
    vec4 look = banks[2 * bank + 1];  // alpha, texture offset, flatness
    bool right = corner == 1 || corner == 2 || corner == 4;
    bool top = corner == 2 || corner == 4 || corner == 5;
    v_corner = vec2(right ? 1.0 : -1.0, top ? 1.0 : -1.0);
    v_texture = look.yz + 0.3 * v_corner;
    v_alpha = look.x;
    vec2 offset = place.w * v_corner * vec2(1.0, look.w);
    mat3 axes = transpose(mat3(u_view));
    v_world = place.xyz + axes[0] * offset.x + axes[1] * offset.y;
    gl_Position = u_projection * (u_view * vec4(v_world, 1.0));
}
