// The k nearest fragments, and the others as so many layers of their mean (Maule et al. 2013).
vec4 tail_sum;  // of premultiplied colour, and of alpha
uint tail_count;

#ifdef TAIL_PACKED
// Steps of 1/255, 10 bits a colour and 16 for alpha and count.
vec4 kept_tail(vec4 sum) {
    const vec4 most = vec4(1023.0, 1023.0, 1023.0, 65535.0);
    precise vec4 steps = clamp(sum, 0.0, 4e6) * 255.0 + 0.5;
    precise vec4 kept = min(floor(steps), most) / 255.0;
    return kept;
}
const uint kMostCounted = 65535u;
#else
vec4 kept_tail(vec4 sum) { return TAIL(sum); }
const uint kMostCounted = 0xFFFFFFFFu;
#endif

void add_to_tail(vec4 color) {
    precise vec4 sum = tail_sum + color;
    tail_sum = kept_tail(sum);
    if (tail_count < kMostCounted) ++tail_count;
}
// 1 - (1 - mean)^count; by series where digits would be lost.
float combined_alpha(float mean, float count) {
    if (count <= 1.0) return mean * count;
    precise float series =
        mean * (1.0 + mean * (0.5 + mean * ((1.0 / 3.0) + mean * 0.25)));
    float density = mean < 1.0 / 64.0 ? series : -natural_log(1.0 - mean);
    precise float depth = count * density;
    precise float thin = depth * (1.0 - depth * (0.5 - depth * ((1.0 / 6.0) - depth * (1.0 / 24.0))));
    precise float many = 1.0 - exponential(-depth);
    return depth < 1.0 / 16.0 ? thin : many;
}

vec3 resolved(ivec2 pixel) {
    clear_layers();
    tail_sum = vec4(0.0);
    tail_count = 0u;
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) {
        vec4 color = COLOR(vec4(premultiplied_of(node(n)), node(n).alpha));
        int at = layers_before(node(n).z);
        if (at == LAYERS) {
            add_to_tail(color);
            continue;
        }
        if (layers_full()) add_to_tail(layer_color[LAYERS - 1]);
        insert_layer(at, node(n).z, color);
    }
    vec4 core = composited_layers();
    precise float mean = tail_sum.a / (tail_count == 0u ? 1.0 : float(tail_count));
    float total = combined_alpha(mean, float(tail_count));
    float factor = 1.0;
#ifdef TAIL_FACTOR
    if (tail_sum.a > 0.0) factor = total;
#endif
    precise float scale = factor / (tail_sum.a > 0.0 ? tail_sum.a : 1.0);
    precise float front = core.a * scale;
    precise float behind = core.a * (1.0 - total);
    precise vec3 color = core.rgb + front * tail_sum.rgb + behind * background_of(pixel);
    return color;
}
