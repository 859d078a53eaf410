// A mesh with a colour, the sunlight that arrives and a finish at every vertex, binding 1.
struct Vertex {
    vec4 place;   // w: sunlight that arrives, 0 to 1
    vec4 normal;  // w: finish, see scenery_mesh.h
    vec4 color;
};
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out float v_finish;
out vec4 v_color;
out vec3 v_world;
out vec4 v_normal;  // w: sunlight that arrives
out vec3 v_to_eye;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    Vertex vertex = vertices[gl_VertexID];
    v_finish = vertex.normal.w;
    v_color = vertex.color;
    v_world = vertex.place.xyz;
    v_normal = vec4(vertex.normal.xyz, vertex.place.w);
    vec3 eye = -(transpose(mat3(u_view)) * u_view[3].xyz);
    v_to_eye = eye - vertex.place.xyz;
    gl_Position = u_projection * (u_view * vec4(vertex.place.xyz, 1.0));
}
