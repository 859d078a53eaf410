// Instanced mesh: positions and normals at binding 1, a model matrix and a colour an instance at binding 2.
struct Vertex {
    vec4 position;
    vec4 normal;
};
struct Instance {
    mat4 model;
    vec4 color;
};
layout(std430, binding = 1) readonly buffer Vertices { Vertex vertices[]; };
layout(std430, binding = 2) readonly buffer Instances { Instance instances[]; };
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
flat out uint v_instance;
flat out vec4 v_color;
out vec3 v_world;
out vec3 v_normal;  // world space
out vec3 v_to_eye;  // world space

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    Instance instance = instances[v_instance];
    vec4 world = instance.model * vec4(vertices[gl_VertexID].position.xyz, 1.0);
    v_world = world.xyz;
    // Columns over their squared lengths: the inverse transpose of rotation times scale.
    vec3 normal = vertices[gl_VertexID].normal.xyz;
    mat3 m = mat3(instance.model);
    v_normal = m[0] * (normal.x / dot(m[0], m[0])) + m[1] * (normal.y / dot(m[1], m[1])) +
               m[2] * (normal.z / dot(m[2], m[2]));
    vec3 eye = -(transpose(mat3(u_view)) * u_view[3].xyz);
    v_to_eye = eye - world.xyz;
    v_color = instance.color;
    gl_Position = u_projection * (u_view * world);
}
