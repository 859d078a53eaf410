// Multi-layer alpha blending (Salvi and Vaidyanathan 2014): a fragment more than LAYERS and the last two become one.
// A layer is premultiplied colour and its own transmittance.
const float kUnused = 1e30;
float layer_z[LAYERS + 1];
vec4 layer[LAYERS + 1];

vec4 over(vec4 near, vec4 far) {
    precise vec4 both = vec4(near.rgb + near.a * far.rgb, near.a * far.a);
    return both;
}
vec4 kept_layer(vec4 value) { return vec4(COLOR(value).rgb, OWN_TRANSMITTANCE(value.a)); }
bool stays_in_front(float stored, float z) {
#ifdef TIES_newest
    return stored < z;
#else
    return stored <= z;
#endif
}

void blend(float z, vec4 value) {
    int at = 0;
    while (at < LAYERS && stays_in_front(layer_z[at], z)) ++at;
    for (int i = LAYERS; i > at; --i) {
        layer_z[i] = layer_z[i - 1];
        layer[i] = layer[i - 1];
    }
    layer_z[at] = z;
    layer[at] = kept_layer(value);
    if (layer_z[LAYERS] < kUnused) layer[LAYERS - 1] = kept_layer(over(layer[LAYERS - 1], layer[LAYERS]));
}

vec3 resolved(ivec2 pixel) {
    for (int i = 0; i <= LAYERS; ++i) {
        layer_z[i] = kUnused;
        layer[i] = vec4(0.0, 0.0, 0.0, 1.0);
    }
    for (uint n = first_node(pixel); n != 0u; n = node(n).next)
        blend(node(n).z, vec4(premultiplied_of(node(n)), 1.0 - node(n).alpha));
    // "Over" in pairs.
    for (int stride = 1; stride < LAYERS; stride *= 2)
        for (int i = 0; i + stride < LAYERS; i += 2 * stride) layer[i] = over(layer[i], layer[i + stride]);
    return over(layer[0], vec4(texelFetch(u_opaque_color, ivec3(pixel, 0), 0).rgb, 1.0)).rgb;
}
