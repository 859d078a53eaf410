// Leaves as quads of any direction: six vertices a leaf, two triangles.
layout(std430, binding = 1) readonly buffer Leaves { vec4 leaves[]; };  // three each, see fog_scene.cpp
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out vec3 v_color;
flat out vec3 v_normal;
out vec3 v_world;
out vec3 v_to_eye;
out vec2 v_corner;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int leaf = gl_VertexID / 6;
    int corner = gl_VertexID - 6 * leaf;
    vec4 along = leaves[3 * leaf + 1];   // half the length, red
    vec4 across = leaves[3 * leaf + 2];  // half the width, green
    bool right = corner == 1 || corner == 2 || corner == 4;
    bool top = corner == 2 || corner == 4 || corner == 5;
    v_corner = vec2(right ? 1.0 : -1.0, top ? 1.0 : -1.0);
    v_color = vec3(along.w, across.w, 0.3 * across.w);
    v_normal = normalize(cross(across.xyz, along.xyz));
    v_world = leaves[3 * leaf].xyz + v_corner.y * along.xyz + v_corner.x * across.xyz;
    v_to_eye = -(transpose(mat3(u_view)) * u_view[3].xyz) - v_world;
    gl_Position = u_projection * (u_view * vec4(v_world, 1.0));
}
