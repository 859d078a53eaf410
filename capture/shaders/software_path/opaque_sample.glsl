// The opaque layer's colour at a spatial sample.
uniform uint u_sample;

vec3 resolved(ivec2 pixel) { return texelFetch(u_opaque_color, ivec3(pixel, u_sample), 0).rgb; }
