// The background, displaced and blurred, through what the surfaces leave of it, and their colour over it (McGuire and
// Mara 2017, equations 3 and 14, Listing 3; codes of 63 pixels, Table 2).
layout(binding = 10) uniform sampler2DArray u_accumulated;
layout(binding = 11) uniform sampler2DArray u_beta;
layout(binding = 12) uniform sampler2DArray u_delta;
uniform uint u_max_radius;

const float kVarianceAtOne = 63.0 * 63.0;

vec3 background_at(ivec2 pixel) { return texelFetch(u_opaque_color, ivec3(pixel, 0), 0).rgb; }
// What the target keeps, from what the driver makes of its codes.
vec4 beta_at(ivec2 pixel) { return BETA_STORED(texelFetch(u_beta, ivec3(pixel, 0), 0)); }
float variance_at(ivec2 pixel) {
    precise float variance = beta_at(pixel).a * kVarianceAtOne;
    return variance;
}
ivec2 inside(ivec2 pixel) { return clamp(pixel, ivec2(0), textureSize(u_accumulated, 0).xy - 1); }

vec3 mixed(vec3 a, vec3 b, float part) {
    precise vec3 mean = a + part * (b - a);
    return mean;
}
vec3 displaced(ivec2 pixel, vec2 offset) {
    precise vec2 place = clamp(offset, -16384.0, 16384.0);
    vec2 whole = floor(place);
    precise vec2 part = place - whole;
    ivec2 low = inside(pixel + ivec2(whole));
    ivec2 high = inside(pixel + ivec2(whole) + 1);
    vec3 top = mixed(background_at(low), background_at(ivec2(high.x, low.y)), part.x);
    vec3 bottom = mixed(background_at(ivec2(low.x, high.y)), background_at(high), part.x);
    return mixed(top, bottom, part.y);
}
// Taps two pixels apart within one deviation, each if its own pixel's deviation reaches as far.
vec3 diffused(ivec2 pixel, vec2 offset, float variance) {
    ivec2 center = inside(pixel + ivec2(clamp(offset, -16384.0, 16384.0)));
    int radius = int(min(sqrt(variance), float(u_max_radius)) / 2.0) * 2;
    precise vec4 sum = vec4(0.0);
    for (int v = -radius; v <= radius; v += 2) {
        for (int u = -radius; u <= radius; u += 2) {
            float distance = float(u * u + v * v);
            if (distance > variance) continue;
            ivec2 tap = inside(center + ivec2(u, v));
            float own = variance_at(tap);
            if (distance > own) continue;
            precise float weight = 1.0 / max(own, 0.25) + 1e-5;
            sum += weight * vec4(background_at(tap), 1.0);
        }
    }
    precise vec3 mean = sum.rgb / sum.a;
    return mean;
}

vec3 surface_color(vec4 sum, vec3 beta) {
    float largest = max(max(sum.r, sum.g), sum.b);
    bool overflown = any(isinf(sum.rgb)) || any(isnan(sum.rgb));
    float weights = isinf(sum.a) || isnan(sum.a) ? largest : sum.a;
    precise float scale = 1.0 / max(weights, 1e-5);
    precise vec3 mean = overflown ? vec3(1.0) : sum.rgb * scale;
#ifdef SELF_MODULATES
    float brightest = max(max(beta.r, beta.g), beta.b);
    precise float hue = 1.0 / max(2e-3, brightest + brightest);
    mean *= 0.5 + max(beta, 1e-3) * hue;
#endif
    precise vec3 color = (1.0 - beta) * mean;
    return color;
}

vec3 resolved(ivec2 pixel) {
    vec4 rest = beta_at(pixel);
    vec3 beta = rest.rgb;
    vec2 code = DELTA_STORED(texelFetch(u_delta, ivec3(pixel, 0), 0)).xy;
    bool blurs = false;
    bool moves = false;
#ifdef DIFFUSES
    blurs = rest.a > 0.0;
#endif
#ifdef REFRACTS
    moves = max(abs(code.x), abs(code.y)) > 0.0;
#else
    code = vec2(0.0);
#endif
    vec3 behind = background_at(pixel);
    if (!blurs && !moves && min(min(beta.r, beta.g), beta.b) >= 1.0) return behind;
    precise vec2 offset = code * 63.0;
    if (blurs) behind = diffused(pixel, offset, variance_at(pixel));
    else if (moves) behind = displaced(pixel, offset);
    precise vec3 color =
        behind * beta + surface_color(texelFetch(u_accumulated, ivec3(pixel, 0), 0), beta);
    return color;
}
