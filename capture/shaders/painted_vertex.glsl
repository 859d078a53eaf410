// A mesh with a colour and a share of sunlight at every vertex.
struct Vertex {
    vec4 position;  // w: share of the sunlight that arrives
    vec4 normal;
    vec4 color;
};
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
out vec3 v_color;
out vec4 v_normal;  // world space; w: share of the sunlight

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    Vertex vertex = vertices[gl_VertexID];
    v_color = vertex.color.rgb;
    v_normal = vec4(vertex.normal.xyz, vertex.position.w);
    gl_Position = u_projection * (u_view * vec4(vertex.position.xyz, 1.0));
}
