// Absorbance in front of each of CELLS planes, the last of which stands at the furthest fragment (Kim and Neumann
// 2001).
void add_to_map(float share, float alpha) {
    float amount = -log_transmittance(alpha);
    precise float position = share * float(CELLS);
    for (int k = int(position); k < CELLS; ++k) {
        precise float sum = cell[k] + amount;
        cell[k] = CELL(sum);
    }
}
float map_visibility(float share) {
    precise float position = share * float(CELLS);
    int index = int(position);  // of the next plane
    float before = index > 0 ? cell[index - 1] : 0.0;
#ifdef LOOKUP_linear
    float after = index < CELLS ? cell[index] : 0.0;
    precise float absorbance = before + (position - float(index)) * (after - before);
    return exponential(-absorbance);
#else
    return exponential(-before);
#endif
}
