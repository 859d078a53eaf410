// The stored samples that a fragment asks for (Enderton et al. 2011), by docs/random-numbers.md.
uniform uint u_seed_low;
uniform uint u_seed_high;
uniform uint u_stored;  // samples a pixel
uniform uint u_image_width;

uvec2 stored_coverage(uint visible) {
    uvec2 covered = uvec2(0u);
    for (uint s = 0u; s < u_stored; ++s)
        if ((visible >> (s % u_samples) & 1u) != 0u) covered = mask_with(covered, s);
    return covered;
}

uvec2 asked_samples(Arrival a, uvec2 covered) {
#if defined(SEED_FROM_depth)
    uvec2 first = uvec2(0u, 1u);
    uint second = floatBitsToUint(a.z);
#elif defined(SEED_FROM_object)
    uvec2 first = uvec2(object_of(a), 2u);
    uint second = 0u;
#elif defined(SEED_FROM_object_facing)
    uvec2 first = uvec2(object_of(a), 2u);
    uint second = a.back ? 1u : 0u;
#else
    uvec2 first = uvec2(a.draw, 0u);
    uint second = a.primitive;
#endif
    uint place = a.pixel.y * u_image_width + a.pixel.x;
    uvec2 key = fragment_key(uvec2(u_seed_low, u_seed_high), first, place, second);
#if defined(MASKS_coin)
    return coin_mask(key, u_stored, a.alpha) & covered;
#elif defined(MASKS_run)
    return run_mask(key, u_stored, a.alpha, a.pixel, DITHERED) & covered;
#elif defined(MASKS_alpha_to_coverage)
    return covering_mask(u_stored, a.alpha) & covered;
#else
    return chosen_mask(key, u_stored, covered, a.alpha, a.pixel, DITHERED);
#endif
}
