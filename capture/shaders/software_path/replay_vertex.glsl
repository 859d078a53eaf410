// A fragment of a trace as a point on its pixel.
layout(std430, binding = 1) readonly buffer Records { uint records[]; };
uniform vec4 u_viewport;  // xy: the image's size
flat out uint v_instance;

void main() {
    v_instance = uint(gl_VertexID);
    uint place = records[8u * v_instance + 5u];
    vec2 center = vec2(float(place & 0xFFFFu), float(place >> 16)) + 0.5;
    gl_Position = vec4(2.0 * center.x / u_viewport.x - 1.0, 1.0 - 2.0 * center.y / u_viewport.y, 0.0, 1.0);
}
