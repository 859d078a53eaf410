// Counts a pixel's visible fragments, and those of them that show.
layout(location = 0) out vec2 o_count;

void main() {
    Arrival a = arrival();
    if (visible_samples(a) == 0u) discard;
    o_count = vec2(1.0, a.alpha != 0.0 || a.premultiplied != vec3(0.0) ? 1.0 : 0.0);
}
