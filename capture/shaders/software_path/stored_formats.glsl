// What a target of a format keeps of a value, by integer arithmetic, for blending in the shader: drivers round
// stores as they please.

// Nearest binary16, ties to even; too large becomes infinite.
float kept_float16(float value) {
    uint bits = floatBitsToUint(value);
    uint sign = bits & 0x80000000u;
    uint magnitude = bits ^ sign;
    if (magnitude >= 0x7F800000u) return value;
    if (magnitude >= 0x477FF000u) return uintBitsToFloat(sign | 0x7F800000u);
    if (magnitude >= 0x38800000u) {
        uint odd = (magnitude >> 13) & 1u;
        return uintBitsToFloat(sign | ((magnitude + 0xFFFu + odd) & 0xFFFFE000u));
    }
    // A multiple of 2^-24, the step of binary16's smallest numbers; fewer than 2^-25 is none.
    if (magnitude < 0x33000000u) return uintBitsToFloat(sign);
    uint mantissa = (magnitude & 0x7FFFFFu) | 0x800000u;
    uint cut = 126u - (magnitude >> 23);  // bits below the step: 14 to 24
    uint steps = mantissa >> cut;
    uint rest = mantissa & ((1u << cut) - 1u);
    uint half_step = 1u << (cut - 1u);
    if (rest > half_step || (rest == half_step && (steps & 1u) != 0u)) ++steps;
    return uintBitsToFloat(sign | floatBitsToUint(float(steps) * uintBitsToFloat(0x33800000u)));
}
// The same cut off instead, as some drivers do it.
float cut_float16(float value) {
    uint bits = floatBitsToUint(value);
    uint magnitude = bits & 0x7FFFFFFFu;
    if (magnitude >= 0x7F800000u) return value;
    if (magnitude >= 0x47800000u) return uintBitsToFloat((bits & 0x80000000u) | 0x477FE000u);
    if (magnitude >= 0x38800000u) return uintBitsToFloat(bits & 0xFFFFE000u);
    float steps = floor(uintBitsToFloat(magnitude) * 16777216.0);
    return uintBitsToFloat((bits & 0x80000000u) | floatBitsToUint(steps * uintBitsToFloat(0x33800000u)));
}
// Nearest multiple of 1/255 in [0, 1]; not a number becomes 0.
float kept_unorm8(float value) {
    precise float code = floor((value > 0.0 ? min(value, 1.0) : 0.0) * 255.0 + 0.5);
    precise float kept = code / 255.0;
    return kept;
}
// Nearest multiple of 1/127 in [-1, 1], halves away from zero.
float kept_snorm8(float value) {
    precise float code = floor(min(abs(value), 1.0) * 127.0 + 0.5);
    precise float kept = code / 127.0;
    return value < 0.0 ? -kept : kept;
}
float kept_float32(float value) { return value; }

vec4 kept_float32(vec4 v) { return v; }
vec4 kept_float16(vec4 v) {
    return vec4(kept_float16(v.x), kept_float16(v.y), kept_float16(v.z), kept_float16(v.w));
}
vec4 cut_float16(vec4 v) {
    return vec4(cut_float16(v.x), cut_float16(v.y), cut_float16(v.z), cut_float16(v.w));
}
vec4 kept_unorm8(vec4 v) {
    return vec4(kept_unorm8(v.x), kept_unorm8(v.y), kept_unorm8(v.z), kept_unorm8(v.w));
}
vec4 kept_snorm8(vec4 v) {
    return vec4(kept_snorm8(v.x), kept_snorm8(v.y), kept_snorm8(v.z), kept_snorm8(v.w));
}
