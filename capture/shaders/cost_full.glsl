// The whole fragment shader as an application runs it: colour premultiplied by alpha, for blending.
layout(location = 0) out vec4 o_color;

void main() {
    vec4 color = shade();
    o_color = vec4(color.rgb * color.a, color.a);
}
