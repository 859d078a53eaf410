// Billboards that face the camera: six vertices a particle, two triangles.
layout(std430, binding = 1) readonly buffer Particles { vec4 particles[]; };  // two each, see plume_scene.cpp
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out vec4 v_look;  // light that arrives, alpha, texture offset
out vec2 v_corner;     // -1 to 1 over the billboard
out vec2 v_texture;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int particle = gl_VertexID / 6;
    int corner = gl_VertexID - 6 * particle;
    vec4 place = particles[2 * particle];
    v_look = particles[2 * particle + 1];
    bool right = corner == 1 || corner == 2 || corner == 4;
    bool top = corner == 2 || corner == 4 || corner == 5;
    v_corner = vec2(right ? 1.0 : -1.0, top ? 1.0 : -1.0);
    v_texture = v_look.zw + 0.25 * v_corner;
    vec4 in_camera = u_view * vec4(place.xyz, 1.0);
    in_camera.xy += place.w * v_corner;
    gl_Position = u_projection * in_camera;
}
