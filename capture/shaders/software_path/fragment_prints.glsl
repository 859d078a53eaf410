// Adds a fingerprint of every visible fragment to its pixel's two sums, in any order.
layout(std430, binding = 0) buffer Prints { uint prints[]; };
uniform uint u_width;

uint h = 0u;
void take(uint word) {
    h = (h ^ word) * 0x9E3779B1u;
    h ^= h >> 15;
}
void take(float value) { take(floatBitsToUint(value)); }

uint print_of(Arrival a, uint visible, uint start) {
    h = start;
    take(a.z);
    for (int c = 0; c < 3; ++c) take(a.premultiplied[c]);
    take(a.alpha);
    take(a.primitive | (a.back ? kBackFacing : 0u));
    take(visible | (a.draw << 16));
    take(a.slope.x);
    take(a.slope.y);
    for (int c = 0; c < 3; ++c) take(a.transmission[c]);
    take(a.collimation);
    take(a.eta);
    for (int c = 0; c < 3; ++c) take(a.normal[c]);
    return h;
}

void main() {
    Arrival a = arrival();
    uint visible = visible_samples(a);
    if (visible == 0u) discard;
    uint at = 2u * (a.pixel.y * u_width + a.pixel.x);
    atomicAdd(prints[at], print_of(a, visible, 1u));
    atomicAdd(prints[at + 1u], print_of(a, visible, 2u));
}
