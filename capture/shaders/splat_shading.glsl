// A Gaussian of constant colour; nothing where it hardly shows.
flat in vec4 v_color;
in vec2 v_offset;

vec4 shade() {
    float alpha = min(v_color.a * exp(-0.5 * dot(v_offset, v_offset)), 0.99);
    if (alpha < 1.0 / 255.0) discard;
    return vec4(v_color.rgb, alpha);
}
