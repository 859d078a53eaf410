// What shade() may say about the surface besides colour and alpha; kept where the scene records materials.
vec3 surface_transmission = vec3(0.0);  // of the covered part, per channel
float surface_collimation = 1.0;
float surface_eta = 1.0;
vec3 surface_normal = vec3(0.0);  // world space, towards the viewer; zero: faces the camera

// What shade() returns for a surface that covers `coverage` of the pixel, reflects and emits `radiance` from
// there, and passes `transmission` of what is behind.
//
// McGuire and Mara's equation 1 is alpha L_r + [1 - alpha (1 - t)] L_behind: it, beta, A, the weight and
// Listing 1's D and delta depend on alpha and t through alpha (1 - t) only. Of the pairs that mean the same,
// this one has the least alpha: its most absorbed channel has transmission 0. Techniques that know alpha
// alone then composite colourless glass exactly and see coloured glass as monochrome coverage (the paper's
// Fig. 7, left), where alpha = 1 would have made it opaque; techniques that know transmission lose nothing.
// Only what weights by alpha itself would, diffusion and refraction: see covering().
vec4 transmissive(vec3 radiance, float coverage, vec3 transmission) {
    vec3 absorbed = coverage * (1.0 - clamp(transmission, 0.0, 1.0));
    // Perfectly clear matter keeps a trace of coverage to carry its reflections.
    float alpha = max(max(max(absorbed.r, absorbed.g), absorbed.b), 1.0 / 255.0);
    surface_transmission = 1.0 - absorbed / alpha;
    return vec4(radiance * (coverage / alpha), alpha);
}

// The same with the surface's own coverage and transmission. Equations 6 and 7 weight the diffusion by
// coverage and Listing 1 by coverage times (1 - mean t), refraction may be weighted either way: of the pairs
// that mean the same to equation 1 each diffuses and bends differently, and with the least alpha glass that
// absorbs nothing would do neither. Who knows alpha alone gets the least alpha nevertheless, from the reader
// of the trace (traces/least_alpha.h): the premultiplied colour is the same for all of them.
vec4 covering(vec3 radiance, float coverage, vec3 transmission) {
    surface_transmission = clamp(transmission, 0.0, 1.0);
    return vec4(radiance, coverage);
}
