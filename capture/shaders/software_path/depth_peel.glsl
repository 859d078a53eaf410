// A round of depth peeling (Everitt 2001): of the fragments behind the layer before, the depth test leaves the nearest.
layout(binding = 10) uniform sampler2DArray u_before;  // depths of the layer before
uniform uint u_sample;
uniform uint u_first_round;
layout(location = 0) out vec4 o_layer;

void main() {
    Arrival a = arrival();
    if ((visible_samples(a) >> u_sample & 1u) == 0u) discard;
    float z = DEPTH_SCALE * depth_at(a, u_sample);
    if (u_first_round == 0u && !(texelFetch(u_before, ivec3(a.pixel, 0), 0).r < z)) discard;
    gl_FragDepth = z;
    precise float inverse = a.alpha > 0.0 ? 1.0 / a.alpha : 0.0;
    precise vec3 straight = a.premultiplied * inverse;
    o_layer = LAYER(vec4(straight, a.alpha));
}
