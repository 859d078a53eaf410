// Adaptive transparency (Salvi et al. 2011): a pixel's visibility as at most NODES steps, made from all fragments in a
// first pass over its list and composited with in a second.
const float kUnused = 1e30;
float node_z[NODES + 1];
float node_t[NODES + 1];  // transmittance of everything up to the node

void clear_curve() {
    for (int i = 0; i <= NODES; ++i) {
        node_z[i] = kUnused;
        node_t[i] = 1.0;
    }
}

// By how much the curve changes without node j: `under`, if the node before falls to its transmittance, else if it
// stays.
float removal_error(int j, bool under) {
    precise float drop = (j == 0 ? 1.0 : node_t[j - 1]) - node_t[j];
    precise float width = under ? node_z[j] - node_z[j - 1]
                                : (j == NODES ? 1.0 : node_z[j + 1]) - node_z[j];
    precise float area = drop * width;
    return area;
}
void remove_node(int j, bool under) {
    if (under) node_t[j - 1] = node_t[j];
    for (int i = j; i < NODES; ++i) {
        node_z[i] = node_z[i + 1];
        node_t[i] = node_t[i + 1];
    }
}
void compress() {
    float least = 0.0;
    int chosen = -1;
    bool chosen_under = false;
    for (int j = FIRST_REMOVABLE; j <= LAST_REMOVABLE; ++j) {
#ifndef REMOVAL_overestimate
        if (j >= 1) {
            float error = removal_error(j, true);
            if (chosen < 0 || error < least) {
                least = error;
                chosen = j;
                chosen_under = true;
            }
        }
#endif
#ifndef REMOVAL_underestimate
        float error = removal_error(j, false);
        if (chosen < 0 || error < least) {
            least = error;
            chosen = j;
            chosen_under = false;
        }
#endif
    }
    remove_node(chosen, chosen_under);
}
// A fragment stands in front of a node of its own depth.
void insert(float z, float t) {
    int at = 0;
    while (at < NODES && node_z[at] < z) ++at;
    for (int i = NODES; i > at; --i) {
        node_z[i] = node_z[i - 1];
        precise float product = node_t[i - 1] * t;
        node_t[i] = NODE_TRANSMITTANCE(product);
    }
    precise float own = at == 0 ? t : node_t[at - 1] * t;
    node_z[at] = z;
    node_t[at] = NODE_TRANSMITTANCE(own);
    if (node_z[NODES] < kUnused) compress();
}
float visibility(float z) {
    float v = 1.0;
    for (int i = 0; i < NODES && node_z[i] < z; ++i) v = node_t[i];
    return v;
}

vec3 over_background(vec4 sum, float total, vec3 background) {
    precise vec3 color = sum.rgb;
#ifdef NORMALISED
    const float kLeast = uintBitsToFloat(0x33800000u);  // 2^-24
    precise float scale = sum.a < kLeast ? 1.0 : (1.0 - total) / max(sum.a, kLeast);
    color = color * scale;
#endif
    color = color + total * background;
    return color;
}

#ifdef VARIABLE
// From lists alone, the latest arrival first (section 4.1).
vec4 listed_color(Node n) { return LIST_COLOR(vec4(premultiplied_of(n), n.alpha)); }

vec3 resolved(ivec2 pixel) {
    uint first = reversed(first_node(pixel));
    vec3 color[SAMPLES];
    for (uint m = 0u; m < SAMPLES; ++m) {
        clear_curve();
        for (uint n = first; n != 0u; n = node(n).next)
            if (covers(node(n), m)) insert(listed_depth(node(n).z), 1.0 - listed_color(node(n)).a);
        precise vec4 sum = vec4(0.0);
        for (uint n = first; n != 0u; n = node(n).next)
            if (covers(node(n), m)) sum = sum + visibility(listed_depth(node(n).z)) * listed_color(node(n));
        color[m] = over_background(sum, node_t[NODES - 1], background_at(pixel, m));
    }
    return mean_of_samples(color);
}
#else
// As framebuffer operations (section 4): in order of arrival, one curve for all samples of a pixel.
float transmittance_of(Node n) {
    precise float t = 1.0 - n.alpha * (float(bitCount(coverage_of(n))) / float(SAMPLES));
    return t;
}

vec3 resolved(ivec2 pixel) {
    clear_curve();
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) insert(node(n).z, transmittance_of(node(n)));
    vec3 color[SAMPLES];
    for (uint m = 0u; m < SAMPLES; ++m) {
        vec4 sum = vec4(0.0);
        float total = 1.0;
        for (uint n = first_node(pixel); n != 0u; n = node(n).next) {
            if (!covers(node(n), m)) continue;
            vec4 source = vec4(premultiplied_of(node(n)), node(n).alpha);
            precise vec4 more = sum + visibility(node(n).z) * source;
            sum = COLOR(more);
            precise float dimmed = total * (1.0 - source.a);
            total = COLOR(dimmed);
        }
        if (SAMPLES == 1u) total = node_t[NODES - 1];
        color[m] = over_background(sum, total, background_at(pixel, m));
    }
    return mean_of_samples(color);
}
#endif
