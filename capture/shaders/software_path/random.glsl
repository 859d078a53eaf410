// Random numbers of docs/random-numbers.md, written from that page. 64-bit numbers are uvec2: lower half first.

uvec2 add64(uvec2 a, uvec2 b) {
    uint carry;
    uint low = uaddCarry(a.x, b.x, carry);
    return uvec2(low, a.y + b.y + carry);
}
uvec2 multiply64(uvec2 a, uvec2 b) {
    uint high;
    uint low;
    umulExtended(a.x, b.x, high, low);
    return uvec2(low, high + a.x * b.y + a.y * b.x);
}
uvec2 shifted_right64(uvec2 a, uint by) {  // by 1 to 31
    return uvec2((a.x >> by) | (a.y << (32u - by)), a.y >> by);
}
uint msb(uint a, uint b) {
    uint high;
    uint low;
    umulExtended(a, b, high, low);
    return high;
}

uvec2 mix64(uvec2 x) {
    x = multiply64(x ^ shifted_right64(x, 30u), uvec2(0x1CE4E5B9u, 0xBF58476Du));
    x = multiply64(x ^ shifted_right64(x, 27u), uvec2(0x133111EBu, 0x94D049BBu));
    return x ^ shifted_right64(x, 31u);
}
const uvec2 kGolden = uvec2(0x7F4A7C15u, 0x9E3779B9u);
uint random_bits(uvec2 key, uint draw) {
    return mix64(add64(key, multiply64(kGolden, add64(uvec2(draw, 0u), uvec2(1u, 0u))))).y;
}
float random_unit(uvec2 key, uint draw) { return float(random_bits(key, draw) >> 8) * uintBitsToFloat(0x33800000u); }

uvec2 fragment_key(uvec2 seed, uvec2 first, uint place, uint second) {
    return mix64(mix64(add64(multiply64(seed, kGolden), first)) ^ uvec2(second, place));
}

// Whether a number is below ceil(alpha 2^32).
bool below_alpha(uint number, float alpha) {
    if (alpha >= 1.0) return true;
    return number < uint(ceil(alpha * 4294967296.0));
}

// Masks of up to 64 samples: bit s % 32 of component s / 32.
bool mask_has(uvec2 mask, uint s) { return ((s < 32u ? mask.x : mask.y) >> (s & 31u) & 1u) != 0u; }
uvec2 mask_with(uvec2 mask, uint s) {
    if (s < 32u) mask.x |= 1u << s;
    else mask.y |= 1u << (s - 32u);
    return mask;
}
uint mask_count(uvec2 mask) { return uint(bitCount(mask.x) + bitCount(mask.y)); }

float dither_threshold(uvec2 pixel) {
    uint rank = 0u;
    for (uint b = 0u; b < 3u; ++b)
        rank += (2u * ((pixel.x ^ pixel.y) >> b & 1u) + (pixel.y >> b & 1u)) << (4u - 2u * b);
    return (float(rank) + 0.5) / 64.0;
}

uvec2 coin_mask(uvec2 key, uint samples, float alpha) {
    uvec2 mask = uvec2(0u);
    for (uint s = 0u; s < samples; ++s)
        if (below_alpha(random_bits(key, 1u + s), alpha)) mask = mask_with(mask, s);
    return mask;
}
// R = floor(alpha n + xi).
uint taken_of(uvec2 key, float alpha, uint n, uvec2 pixel, bool dithered) {
    float xi = dithered ? dither_threshold(pixel) : random_unit(key, 0u);
    precise float mean = alpha * float(n);
    precise float sum = mean + xi;
    return uint(sum);
}
uvec2 chosen_mask(uvec2 key, uint samples, uvec2 covered, float alpha, uvec2 pixel, bool dithered) {
    uint left = mask_count(covered);
    uint wanted = taken_of(key, alpha, left, pixel, dithered);
    uvec2 mask = uvec2(0u);
    for (uint s = 0u; s < samples; ++s) {
        if (!mask_has(covered, s)) continue;
        if (msb(random_bits(key, 1u + s), left) < wanted) {
            mask = mask_with(mask, s);
            --wanted;
        }
        --left;
    }
    return mask;
}
uvec2 run_mask(uvec2 key, uint samples, float alpha, uvec2 pixel, bool dithered) {
    uint count = taken_of(key, alpha, samples, pixel, dithered);
    uint start = msb(random_bits(key, 1u), samples);
    uvec2 mask = uvec2(0u);
    for (uint i = 0u; i < count; ++i) mask = mask_with(mask, (start + i) % samples);
    return mask;
}

uint greatest_divisor(uint a, uint b) {
    while (b != 0u) {
        uint rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}
uvec2 covering_mask(uint samples, float alpha) {
    int n = int(samples);
    int step = 1;
    for (int candidate = 1; candidate < n; ++candidate)
        if (greatest_divisor(samples, uint(candidate)) == 1u &&
            abs(1000 * candidate - 618 * n) < abs(1000 * step - 618 * n))
            step = candidate;
    uint count = uint(double(alpha) * double(samples) + 0.5LF);
    uvec2 mask = uvec2(0u);
    for (uint i = 0u; i < count; ++i) mask = mask_with(mask, i * uint(step) % samples);
    return mask;
}

uint hilbert_index(uint order, uvec2 pixel) {
    uint index = 0u;
    for (uint side = order == 0u ? 0u : 1u << (order - 1u); side != 0u; side >>= 1) {
        uvec2 at = uvec2((pixel.x & side) != 0u ? 1u : 0u, (pixel.y & side) != 0u ? 1u : 0u);
        index += side * side * ((3u * at.x) ^ at.y);
        if (at.y == 0u) {
            if (at.x == 1u) pixel ^= uvec2(2u * side - 1u);
            pixel = pixel.yx;
        }
    }
    return index;
}
uint morton_index(uvec2 pixel) {
    uint index = 0u;
    for (uint b = 0u; b < 16u; ++b)
        index |= (pixel.x >> b & 1u) << (2u * b) | (pixel.y >> b & 1u) << (2u * b + 1u);
    return index;
}
uint opacity_reference(uint index, uint surface) {
    uint x = bitfieldReverse(index) + surface;
    x ^= x * 0x6C50B47Cu;
    x ^= x * 0xB82F1E52u;
    x ^= x * 0xC7AFE638u;
    x ^= x * 0x8D22F6E6u;
    return x;
}

uint hash_words(uvec3 words, uint seed) {
    uint h = words.x * 0x9E3779B1u + words.y * 0x85EBCA77u + words.z * 0xC2B2AE3Du + seed;
    h = (h ^ h >> 16) * 0x7FEB352Du;
    h = (h ^ h >> 15) * 0x846CA68Bu;
    return h ^ h >> 16;
}
float hashed_unit(uint hash) { return float((hash >> 8) + 1u) * uintBitsToFloat(0x33800000u); }
