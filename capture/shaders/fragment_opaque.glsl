// Writes opaque colour; alpha 1 marks the pixel as drawn.
layout(location = 0) out vec4 o_color;

void main() { o_color = vec4(max(shade().rgb, vec3(0.0)), 1.0); }
