// Logarithm, exponential, sine and cosine to the last bit of a float, by series in double precision: a driver's own are
// no better than it likes.

// 1e-14 and better; -infinity at 0 and below.
float natural_log(float x) {
    if (!(x > 0.0)) return uintBitsToFloat(0xFF800000u);
    uint bits = floatBitsToUint(x);
    int exponent = int(bits >> 23) - 127;
    double m = double(uintBitsToFloat((bits & 0x7FFFFFu) | 0x3F800000u));
    if (m > 1.4142135623730951LF) {
        m *= 0.5LF;
        ++exponent;
    }
    // ln m = 2 atanh s.
    double s = (m - 1.0LF) / (m + 1.0LF);
    double s2 = s * s;
    double series = 0.0LF;
    for (int n = 21; n >= 1; n -= 2) series = series * s2 + 1.0LF / double(n);
    return float(double(exponent) * 0.69314718055994531LF + 2.0LF * s * series);
}
float exponential(float x) {
    if (x < -104.0) return 0.0;
    if (x > 89.0) return uintBitsToFloat(0x7F800000u);
    double turns = double(x) * 1.4426950408889634LF;
    double whole = floor(turns + 0.5LF);
    double u = (turns - whole) * 0.69314718055994531LF;
    double series = 1.0LF;
    for (int n = 14; n >= 1; --n) series = 1.0LF + series * u / double(n);
    return float(series * packDouble2x32(uvec2(0u, uint(int(whole) + 1023) << 20)));
}
// Of an angle in turns.
vec2 sine_cosine(float turns) {
    double quarter = floor(4.0LF * double(turns) + 0.5LF);
    double x = (double(turns) - 0.25LF * quarter) * 6.2831853071795865LF;
    double x2 = x * x;
    double sine = 1.0LF;
    double cosine = 1.0LF;
    for (int n = 8; n >= 1; --n) {
        sine = 1.0LF - sine * x2 / double(2 * n * (2 * n + 1));
        cosine = 1.0LF - cosine * x2 / double((2 * n - 1) * 2 * n);
    }
    vec2 both = vec2(float(sine * x), float(cosine));
    int turned = int(quarter) & 3;
    if (turned == 1) return vec2(both.y, -both.x);
    if (turned == 2) return -both;
    if (turned == 3) return vec2(-both.y, both.x);
    return both;
}
