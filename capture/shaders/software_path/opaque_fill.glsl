// Colour and depth of the opaque layer at a spatial sample, as samples start.
uniform uint u_sample;
layout(location = 0) out vec4 o_color;

void main() {
    ivec3 place = ivec3(gl_FragCoord.xy, u_sample);
    o_color = STORED(vec4(texelFetch(u_opaque_color, place, 0).rgb, 1.0));
    float depth = texelFetch(u_opaque_depth, place, 0).r;
    gl_FragDepth = isinf(depth) ? 1.0 : DEPTH_SCALE * depth;
}
