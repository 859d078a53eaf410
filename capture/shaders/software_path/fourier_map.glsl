// The density of absorbance over depth as the first coefficients of its Fourier series (Jansen and Bavoil 2010): a_0,
// a_1, b_1, a_2, b_2 ...
const int kPairs = CELLS / 2;

float guarded(float share) {
#ifdef GUARDED
    precise float inside = GUARD + share * UNGUARDED;
    return inside;
#else
    return share;
#endif
}
vec2 waves(float share, int k) {
    precise float turns = share * float(k);
    return sine_cosine(turns);
}

void add_to_map(float share, float alpha) {
    precise float amount = log_transmittance(alpha) * -2.0;
    float at = guarded(share);
    precise float sum = cell[0] + amount;
    cell[0] = CELL(sum);
    for (int k = 1; k <= kPairs; ++k) {
        vec2 wave = waves(at, k);
        precise float a = cell[2 * k - 1] + amount * wave.y;
        precise float b = cell[2 * k] + amount * wave.x;
        cell[2 * k - 1] = CELL(a);
        cell[2 * k] = CELL(b);
    }
}
float map_visibility(float share) {
    float at = guarded(share);
    float term[CELLS];
    precise float mean = cell[0] * (at * 0.5);
    term[0] = mean;
    for (int k = 1; k <= kPairs; ++k) {
        vec2 wave = waves(at, k);
        float scale = float(0.15915494309189535LF / double(k));  // 1 / (2 pi k)
        precise float a = cell[2 * k - 1] * (wave.x * scale);
        precise float b = cell[2 * k] * ((1.0 - wave.y) * scale);
        term[2 * k - 1] = a;
        term[2 * k] = b;
    }
    float absorbance = tree_sum(term);
#ifdef CLAMPED
    return exponential(-max(absorbance, 0.0));
#else
    return min(exponential(-absorbance), 65504.0);
#endif
}
