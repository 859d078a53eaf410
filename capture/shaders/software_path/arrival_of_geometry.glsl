// Fragments of a scene's own geometry: shaded by its shade(), at the depth that the rasteriser gives them.
#define DEPTH_SCALE 1.0
flat in uint v_instance;
uniform uint u_primitives;
uniform uint u_first_primitive;
uniform uint u_draw;
uniform uint u_draw_start;  // triangles of the draws before this one
uniform mat4 u_view;

Arrival arrival() {
    vec4 color = shade();
    Arrival a;
    a.pixel = uvec2(gl_FragCoord.xy);
    a.z = clamp(gl_FragCoord.z, 0.0, 1.0);
    a.slope = vec2(0.0);
    a.alpha = clamp(color.a, 0.0, 1.0);
    a.premultiplied = max(color.rgb, vec3(0.0)) * a.alpha;
    a.primitive = v_instance * u_primitives + u_first_primitive + uint(gl_PrimitiveID);
    a.back = !gl_FrontFacing;
    a.draw = u_draw;
    a.coverage = 1u;
    a.order = u_draw_start + a.primitive;
    a.transmission = vec3(0.0);
    a.collimation = 1.0;
    a.eta = 1.0;
    a.normal = vec3(0.0, 0.0, 1.0);
#ifdef MATERIALS
    a.transmission = clamp(surface_transmission, 0.0, 1.0);
    a.collimation = clamp(surface_collimation, 0.0, 1.0);
    a.eta = surface_eta;
    if (surface_normal != vec3(0.0)) a.normal = normalize(mat3(u_view) * surface_normal);
#ifndef READS_MATERIALS
    // Who knows alpha alone gets the least that means the same.
    float absorbed = 1.0 - min(min(a.transmission.r, a.transmission.g), a.transmission.b);
    a.alpha = max(a.alpha * absorbed, min(a.alpha, 1.0 / 255.0));
#endif
#endif
    return a;
}
