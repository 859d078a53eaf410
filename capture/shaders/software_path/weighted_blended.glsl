// Weighted blended transparency (McGuire and Bavoil 2013): weighted premultiplied colour, and alpha.
float weight_of(float z, float alpha) {
#if defined(WEIGHT_eq10)
    precise float behind = 1.0 - z;
    precise float w = alpha * max(0.01, 3000.0 * (behind * behind * behind));
#elif defined(WEIGHT_blog2015)
    precise float part = (alpha * 8.0 + 0.01) * (1.0 - z * 0.95);
    precise float w = clamp(1000.0 * (part * part * part), 0.01, 300.0);
#elif defined(WEIGHT_learnopengl)
    precise float a = min(1.0, alpha * 10.0) + 0.01;
    precise float d = 1.0 - z * 0.9;
    precise float w = clamp(1e8 * ((a * a * a) * (d * d * d)), 0.01, 3000.0);
#else
    precise float w = 1.0;
#endif
    return w;
}

bool sources(Arrival a, out vec4 source[TARGETS]) {
    precise float w = weight_of(a.z, a.alpha);
    precise vec4 weighted = w * vec4(a.premultiplied, a.alpha);
    source[0] = weighted;
    source[1] = vec4(a.alpha);
    return visible_samples(a) != 0u;
}
