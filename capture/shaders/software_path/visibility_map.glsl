// A map of visibility over depth: CELLS numbers, to which a fragment adds. A map's file defines
//     void add_to_map(float share, float alpha); float map_visibility(float share);
// of a depth at `share` of the way from the pixel's nearest to its furthest.
float cell[CELLS];
float tree_sum(float term[CELLS]) {
    for (int stride = 1; stride < CELLS; stride *= 2)
        for (int i = 0; i + stride < CELLS; i += 2 * stride) {
            precise float sum = term[i] + term[i + stride];
            term[i] = sum;
        }
    return term[0];
}
// ln of transmittance.
float log_transmittance(float alpha) { return natural_log(max(1.0 - alpha, LEAST_TRANSMITTANCE)); }
