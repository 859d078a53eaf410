// Adds one to the pixel for every fragment that shading does not discard.
layout(location = 0) out vec4 o_count;

void main() {
    shade();
    o_count = vec4(1.0);
}
