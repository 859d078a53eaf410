// As cost_full.glsl, with what shade() says about the surface besides.
layout(location = 0) out vec4 o_color;
layout(location = 1) out vec4 o_transmission;  // and collimation
layout(location = 2) out vec4 o_normal;        // and index of refraction

void main() {
    vec4 color = shade();
    o_color = vec4(color.rgb * color.a, color.a);
    o_transmission = vec4(surface_transmission, surface_collimation);
    o_normal = vec4(surface_normal, surface_eta);
}
