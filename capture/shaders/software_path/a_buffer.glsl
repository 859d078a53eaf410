// Composites a pixel's list front to back, sorted by depth (Carpenter 1984; as lists: Yang et al. 2010). Of equal depths
// the earlier arrival is nearer.
uint sorted_by_depth(uint rest) {
    uint first = 0u;
    while (rest != 0u) {
        uint at = rest - 1u;
        rest = nodes_in_use[at].next;
        float z = listed_depth(nodes_in_use[at].z);
        uint after = first;
        uint before = 0u;
        while (after != 0u && listed_depth(nodes_in_use[after - 1u].z) <= z) {
            before = after;
            after = nodes_in_use[after - 1u].next;
        }
        nodes_in_use[at].next = after;
        if (before == 0u) first = at + 1u;
        else nodes_in_use[before - 1u].next = at + 1u;
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
