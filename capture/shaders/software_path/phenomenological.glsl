// What a surface exports (McGuire and Mara 2017, section 4 and Listing 1): weighted colour and net coverage; what it
// takes from each channel behind it, and the variance that it blurs with; where it moves what is behind.
uniform mat4 u_lens;  // the camera's projection
uniform vec4 u_image_size;
uniform vec4 u_scattering;  // k0, k1 in metres, depth of refraction in metres, pixels a metre at distance 1

const float kPixelsAtOne = 63.0;

float weight_of(float z, float net) {
#ifdef WEIGHT_none
    return 1.0;
#else
    precise float w = 10.0 * (1.0 - 0.99 * z) * net;
    precise float cube = w * w * w;
    return clamp(cube, 0.01, 30.0);
#endif
}

// Of the background behind the surface alone, in pixels: equations 6 and 7.
float deviation_of(Arrival a) {
    float here = view_distance(a.z);
    float behind = texelFetch(u_opaque_depth, ivec3(a.pixel, 0), 0).r;
    precise float thickness = 1.0;
    if (behind < 1.0) thickness = 1.0 - u_scattering.y / (u_scattering.y + max(view_distance(behind) - here, 0.0));
    precise float pixels = u_distance.z != 0.0 ? u_scattering.w / max(here, 1e-6) : u_scattering.w / u_distance.w;
    precise float deviation = pixels * u_scattering.x * (1.0 - a.collimation) * a.alpha * thickness;
    return min(deviation, 1e6);
}

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}
// Of the place seen through the surface, in pixels to the right and down: Snell's law at the surface, then the plane
// at the depth of refraction (equations 8 to 10).
vec2 displacement_of(Arrival a) {
    if (!(a.eta > 0.0)) return vec2(0.0);
    precise vec2 center = vec2(a.pixel) + 0.5;
    precise float depth = -(view_distance(a.z) / u_distance.w);
    precise float w = u_lens[2][3] * depth + u_lens[3][3];
    precise float ndc_x = 2.0 * center.x / u_image_size.x - 1.0;
    precise float ndc_y = 1.0 - 2.0 * center.y / u_image_size.y;
    precise float at_x = (ndc_x * w - u_lens[2][0] * depth - u_lens[3][0]) / u_lens[0][0];
    precise float at_y = (ndc_y * w - u_lens[2][1] * depth - u_lens[3][1]) / u_lens[1][1];
    vec3 at = vec3(at_x, at_y, depth);
    precise float far = sqrt(dot3(at, at));
    precise vec3 to_eye = u_distance.z != 0.0 ? -at / far : vec3(0.0, 0.0, 1.0);
    vec3 normal = dot3(a.normal, to_eye) < 0.0 ? -a.normal : a.normal;
    float cosine = dot3(normal, to_eye);
    precise float eta = 1.0 / a.eta;
    precise float k = 1.0 - eta * eta * (1.0 - cosine * cosine);
    if (k < 0.0) return vec2(0.0);
    precise float along = eta * cosine - sqrt(k);
    precise vec3 ray = along * normal - eta * to_eye;
    if (-ray.z < 0.01) return vec2(0.0);
    precise vec3 behind = at + ray * (u_scattering.z / u_distance.w / -ray.z);
    precise float behind_w = u_lens[2][3] * behind.z + u_lens[3][3];
    precise float seen_x = (u_lens[0][0] * behind.x + u_lens[2][0] * behind.z + u_lens[3][0]) / behind_w;
    precise float seen_y = (u_lens[1][1] * behind.y + u_lens[2][1] * behind.z + u_lens[3][1]) / behind_w;
    precise vec2 pixel = vec2(0.5 * (seen_x + 1.0) * u_image_size.x, 0.5 * (1.0 - seen_y) * u_image_size.y);
    precise vec2 moved = pixel - center;
    return moved;
}

bool sources(Arrival a, out vec4 source[TARGETS]) {
    precise vec3 absorbed = a.alpha * (1.0 - a.transmission);
    precise float mean = a.transmission.r * (1.0 / 3.0) + a.transmission.g * (1.0 / 3.0) +
                         a.transmission.b * (1.0 / 3.0);
    precise float net = a.alpha * max(1.0 - mean, 0.0);
    float w = weight_of(a.z, net);
    precise vec4 weighted = w * vec4(a.premultiplied, net);
    source[0] = weighted;
    precise float variance = 0.0;
#ifdef DIFFUSES
    if (a.collimation < 1.0) {
        precise float stored = deviation_of(a) * (1.0 / kPixelsAtOne);
        variance = stored * stored;
        if (variance > 0.0 && variance < LEAST_DIFFUSION) variance = LEAST_DIFFUSION;
    }
#endif
    source[1] = vec4(absorbed, variance);
    precise vec2 moved = vec2(0.0);
#ifdef REFRACTS
    if (a.eta != 1.0) moved = displacement_of(a) * (net / kPixelsAtOne);
    if (isnan(moved.x) || isinf(moved.x)) moved.x = 0.0;
    if (isnan(moved.y) || isinf(moved.y)) moved.y = 0.0;
#endif
    source[2] = vec4(moved, 0.0, 0.0);
    return visible_samples(a) != 0u;
}
