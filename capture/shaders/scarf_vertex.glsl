// A sheet of woven cloth: position and place in the weave at every vertex.
struct Vertex {
    vec4 position;  // w: share of the sunlight that arrives
    vec4 normal;
    vec4 weave;  // threads across, threads along; z: 0 to 1 from end to end; unused
};
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
out vec4 v_normal;  // world space; w: share of the sunlight
out vec3 v_to_eye;
out vec3 v_weave;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    Vertex vertex = vertices[gl_VertexID];
    v_normal = vec4(vertex.normal.xyz, vertex.position.w);
    v_weave = vertex.weave.xyz;
    vec3 eye = -(transpose(mat3(u_view)) * u_view[3].xyz);
    v_to_eye = eye - vertex.position.xyz;
    gl_Position = u_projection * (u_view * vec4(vertex.position.xyz, 1.0));
}
