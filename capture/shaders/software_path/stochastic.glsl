// The stochastic pass: a fragment into those of its samples that lie in this target, under the depth test.
uniform uint u_first;  // stored sample of the target's first
#ifdef STORED
layout(location = 0) out vec4 o_color;
#endif

void main() {
    Arrival a = arrival();
    uvec2 asked = asked_samples(a, stored_coverage(visible_samples(a)));
    uint mine = 0u;
    for (uint i = 0u; i < TARGET_SAMPLES; ++i)
        if (mask_has(asked, u_first + i)) mine |= 1u << i;
    if (mine == 0u) discard;
#if TARGET_SAMPLES > 1
    gl_SampleMask[0] = int(mine);
#endif
#ifdef REPLAYED
    gl_FragDepth = DEPTH_SCALE * depth_at(a, u_first % u_samples);
#endif
#ifdef STORED
    precise float inverse = a.alpha > 0.0 ? 1.0 / a.alpha : 0.0;
    precise vec3 straight = a.premultiplied * inverse;
    o_color = STORED(vec4(straight, 1.0));
#endif
}
