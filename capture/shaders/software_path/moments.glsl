// Four power moments of absorbance over depth (Muenstermann et al. 2018).
uniform vec4 u_warp;   // slope, scale, offset; w: 1 logarithm of the distance, 2 distance, 0 window depth
uniform vec4 u_bias;   // weight of the distribution that is not singular, share of the own point, limit of absorbance
const vec4 kBiasMoments = vec4(0.0, 0.375, 0.0, 0.375);

float absorbance_of(float alpha) { return clamp(-natural_log(1.0 - alpha), 0.0, u_bias.z); }
// From -1 to 1 over the range of distances.
float place_of(float z) {
    float depth = clamp(z, 0.0, 1.0);
    if (u_warp.w != 0.0) {
        precise float nearness = 1.0 - u_warp.x * depth;
        precise float distance =
            (u_warp.w == 1.0 ? natural_log(nearness) * u_warp.y : u_warp.y / nearness) + u_warp.z;
        depth = clamp(distance, 0.0, 1.0);
    }
    precise float place = 2.0 * depth - 1.0;
    return place;
}
