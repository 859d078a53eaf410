// A sheet of cloth: two vec4 a vertex, and where each of its copies hangs.
layout(std430, binding = 1) readonly buffer Vertices { vec4 vertices[]; };  // position, u; normal, v
layout(std430, binding = 2) readonly buffer Copies { vec4 copies[]; };      // offset, scale about u_parameters[1]
uniform mat4 u_view;
uniform mat4 u_projection;
uniform uint u_first_instance;
uniform vec4 u_parameters[8];  // 0: direction towards the light; 1: centre, alpha
flat out uint v_instance;
out vec3 v_normal;
out vec3 v_to_eye;
out vec2 v_texture;

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    vec4 place = vertices[2 * gl_VertexID];
    vec4 facing = vertices[2 * gl_VertexID + 1];
    vec4 copy = copies[v_instance];
    vec3 world = u_parameters[1].xyz + copy.w * (place.xyz - u_parameters[1].xyz) + copy.xyz;
    vec3 eye = -(transpose(mat3(u_view)) * u_view[3].xyz);
    v_normal = facing.xyz;
    v_to_eye = eye - world;
    v_texture = vec2(place.w, facing.w);
    gl_Position = u_projection * (u_view * vec4(world, 1.0));
}
