// The k nearest fragments, the others dropped (Bavoil et al. 2007).
vec3 resolved(ivec2 pixel) {
    clear_layers();
    for (uint n = first_node(pixel); n != 0u; n = node(n).next) {
        int at = layers_before(node(n).z);
        if (at < LAYERS) insert_layer(at, node(n).z, COLOR(vec4(premultiplied_of(node(n)), node(n).alpha)));
    }
    return over_background(composited_layers(), background_of(pixel));
}
