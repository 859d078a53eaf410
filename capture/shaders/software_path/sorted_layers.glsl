// A pixel's LAYERS nearest fragments, sorted; of equal depths the earlier arrival is nearer. Colours premultiplied,
// with alpha.
const float kUnused = 1e30;
float layer_z[LAYERS];
vec4 layer_color[LAYERS];

void clear_layers() {
    for (int i = 0; i < LAYERS; ++i) {
        layer_z[i] = kUnused;
        layer_color[i] = vec4(0.0);
    }
}
bool layers_full() { return layer_z[LAYERS - 1] < kUnused; }
// How many are nearer than a fragment at z that arrives now.
int layers_before(float z) {
    int count = 0;
    while (count < LAYERS && layer_z[count] <= z) ++count;
    return count;
}
// Strictly in front of z.
int layers_in_front(float z) {
    int count = 0;
    while (count < LAYERS && layer_z[count] < z) ++count;
    return count;
}
// At place `at`, the furthest dropping out.
void insert_layer(int at, float z, vec4 color) {
    for (int i = LAYERS - 1; i > at; --i) {
        layer_z[i] = layer_z[i - 1];
        layer_color[i] = layer_color[i - 1];
    }
    layer_z[at] = z;
    layer_color[at] = color;
}
// Of the first `count` layers, multiplied in pairs.
float transmittance_of_layers(int count) {
    float product[LAYERS];
    for (int i = 0; i < LAYERS; ++i) product[i] = 1.0 - layer_color[i].a;
    for (int stride = 1; stride < count; stride *= 2)
        for (int i = 0; i + stride < count; i += 2 * stride) {
            precise float pair = product[i] * product[i + stride];
            product[i] = pair;
        }
    return count == 0 ? 1.0 : product[0];
}
// Composited front to back: colour, and transmittance of all.
vec4 composited_layers() {
    precise vec3 sum = vec3(0.0);
    precise float t = 1.0;
    for (int i = 0; i < LAYERS; ++i) {
        sum = sum + t * layer_color[i].rgb;
        t = t * (1.0 - layer_color[i].a);
    }
    return vec4(sum, t);
}
vec3 background_of(ivec2 pixel) { return texelFetch(u_opaque_color, ivec3(pixel, 0), 0).rgb; }
vec3 over_background(vec4 front, vec3 background) {
    precise vec3 color = front.rgb + front.a * background;
    return color;
}
