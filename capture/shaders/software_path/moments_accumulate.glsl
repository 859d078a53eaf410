// Colour times the visibility that four moments give a depth: the share of absorbance in front lies between two
// bounds, of distributions whose support is the depth itself and two more points.
layout(binding = 10) uniform sampler2DArray u_absorbance;
layout(binding = 11) uniform sampler2DArray u_moments;

const float kNoise = uintBitsToFloat(0x34000000u);  // 2^-23, of moments as float32

// Orthogonal polynomials p_1 = z - shift.x, p_2 = (z - shift.y) p_1 - norm.x, and their norms.
struct Polynomials {
    vec2 shift;
    vec2 norm;
};
// Chebyshev's algorithm over the moments 1, b.x .. b.w.
Polynomials polynomials_of(vec4 b) {
    Polynomials p;
    // <p_1, z^l>, l = 1, 2, 3.
    precise vec3 mixed = b.yzw - b.x * b.xyz;
    bool concentrated = !(kNoise < mixed.x);
    mixed.x = max(mixed.x, kNoise);
    precise float shift = clamp(mixed.y / mixed.x - b.x, -1.0, 1.0);
    if (concentrated) shift = 0.0;
    // <p_2, z^2>.
    precise float last = mixed.z - shift * mixed.y - mixed.x * b.y;
    last = max(last, kNoise);
    precise float norm = last / mixed.x;
    p.shift = vec2(b.x, shift);
    p.norm = vec2(mixed.x, concentrated ? 0.25 : norm);
    return p;
}
// A point's weight is one over the sum of the squares of p_0, p_1, p_2 there, each over its norm.
float weight_at(Polynomials p, float z, float distance) {
    precise float first = distance + (z - p.shift.x);
    precise float second = (distance + (z - p.shift.y)) * first - p.norm.x;
    precise float sum = p.norm.x * p.norm.y + first * first * p.norm.y + second * second;
    precise float weight = 1.0 / sum;
    return weight;
}
float share_in_front(vec4 moments, float z) {
    precise vec4 b = moments + (kBiasMoments - moments) * u_bias.x;
    Polynomials p = polynomials_of(b);
    // The support beside z, as a quadratic of the distance from it.
    precise float p1 = z - p.shift.x;
    precise float p2 = (z - p.shift.y) * p1 - p.norm.x;
    precise float slope2 = (z - p.shift.y) + p1;
    precise float factor1 = p1 * p.norm.y;
    precise float c0 = p.norm.x * p.norm.y + factor1 * p1 + p2 * p2;
    precise float c1 = factor1 + p2 * slope2;
    // Roots of s^2 + (c1 / c0) s + p2 / c0, s one over the distance; the larger one first.
    precise float own = 1.0 / c0;
    precise float half_b = 0.5 * (c1 * own);
    precise float c = p2 * own;
    precise float square = half_b * half_b - c;
    precise float root = square > 0.0 ? sqrt(square) : 0.0;
    precise float larger = half_b < 0.0 ? root - half_b : -(half_b + root);
    precise float smaller = abs(larger) < 1e-30 ? 0.0 : c / larger;
    vec2 inverse = vec2(larger, smaller);
    precise float front = u_bias.y * own;
    precise float all = own;
    for (int i = 0; i < 2; ++i) {
        precise float distance = 1.0 / (abs(inverse[i]) < 1e-4 ? 1e-4 : inverse[i]);
        float weight = weight_at(p, z, distance);
        all = all + weight;
        if (inverse[i] < 0.0) front = front + weight;
    }
    precise float share = front / all;
    return share;
}

bool sources(Arrival a, out vec4 source[TARGETS]) {
    ivec3 place = ivec3(a.pixel, 0);
    float total = texelFetch(u_absorbance, place, 0).r;
    float visibility = 1.0;
    if (!(total < 1e-6)) {
        precise float inverse = 1.0 / total;
        precise vec4 moments = texelFetch(u_moments, place, 0) * inverse;
        precise float in_front = total * share_in_front(moments, place_of(a.z));
        visibility = exponential(-(in_front < MOST_IN_FRONT ? in_front : MOST_IN_FRONT));
    }
    precise vec4 seen = visibility * vec4(a.premultiplied, a.alpha);
    source[0] = seen;
    return visible_samples(a) != 0u;
}
