// Composites a pixel's list front to back, sorted by depth (Carpenter 1984; as lists: Yang et al. 2010). Of equal
// depths the earlier arrival is nearer.
uint next_of(uint n) { return nodes_in_use[n - 1u].next; }
float depth_of(uint n) { return listed_depth(nodes_in_use[n - 1u].z); }

// Merges neighbouring runs of 1, 2, 4 ... nodes: a driver may bound the rounds of a shader's loops.
uint sorted_by_depth(uint first) {
    uint runs = 2u;
    for (uint length = 1u; runs > 1u; length *= 2u) {
        uint rest = first;
        uint last = 0u;
        for (runs = 0u; rest != 0u; ++runs) {
            uint a = rest;
            uint b = a;
            uint a_left = 0u;
            for (; a_left < length && b != 0u; ++a_left) b = next_of(b);
            uint b_left = length;
            while (a_left > 0u || (b_left > 0u && b != 0u)) {
                // Of equal depths the one from the run before, which arrived earlier.
                bool later = a_left == 0u || (b_left > 0u && b != 0u && depth_of(b) < depth_of(a));
                uint taken = later ? b : a;
                if (later) {
                    b = next_of(b);
                    --b_left;
                } else {
                    a = next_of(a);
                    --a_left;
                }
                if (last == 0u) first = taken;
                else nodes_in_use[last - 1u].next = taken;
                last = taken;
            }
            rest = b;
        }
        if (last != 0u) nodes_in_use[last - 1u].next = 0u;
    }
    return first;
}

vec3 resolved(ivec2 pixel) {
    uint first = sorted_by_depth(first_node(pixel));
    vec3 color[SAMPLES];
    for (uint m = 0u; m < SAMPLES; ++m) {
        precise vec3 sum = vec3(0.0);
        precise float transmittance = 1.0;
        for (uint n = first; n != 0u; n = node(n).next) {
            if (!covers(node(n), m)) continue;
            vec4 kept = LIST_COLOR(vec4(premultiplied_of(node(n)), node(n).alpha));
            sum = sum + transmittance * kept.rgb;
            transmittance = transmittance * (1.0 - kept.a);
        }
        sum = sum + transmittance * background_at(pixel, m);
        color[m] = sum;
    }
    return mean_of_samples(color);
}
