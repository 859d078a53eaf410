// Glass and clear plastic: mirrors environment() by Fresnel's law, transmits the instance's colour, and shows
// some light that took its way through the matter by inner reflections. After an environment; SURFACE is
// transmissive or covering (surface.glsl).
flat in vec4 v_color;  // transmission of one surface at normal incidence; its alpha is coverage
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
// 0: direction towards the sun, 1: the sun's colour; 2: reflectance at normal incidence, index of refraction
// for the background's refraction, share of light that comes by inner reflections, glossy exponent
uniform vec4 u_parameters[8];

vec4 shade() {
    vec3 to_eye = normalize(v_to_eye);
    vec3 normal = normalize(v_normal);
    normal = dot(normal, to_eye) < 0.0 ? -normal : normal;
    float cosine = dot(normal, to_eye);
    float away = 1.0 - cosine;
    float fresnel = u_parameters[2].x + (1.0 - u_parameters[2].x) * away * away * away * away * away;
    // Snell's law with 1.5 gives the length of the way through a wall; Beer's law the rest.
    float inner_cosine = sqrt(1.0 - (1.0 - cosine * cosine) / 2.25);
    vec3 through = exp2(log2(v_color.rgb) / inner_cosine);

    vec3 mirrored = environment(reflect(-to_eye, normal));
    float facing_sun = max(dot(reflect(-to_eye, normal), u_parameters[0].xyz), 0.0);
    vec3 radiance = fresnel * mirrored + u_parameters[1].rgb * fresnel * pow(facing_sun, u_parameters[2].w);
    // Bent twice, on the way in and out.
    vec3 inner = environment(refract(-to_eye, normal, 0.5)) * through * through;
    float share = u_parameters[2].z * (1.0 - fresnel);
    radiance += share * inner;

    surface_eta = u_parameters[2].y;
    surface_normal = normal;
    return SURFACE(radiance, v_color.a, through * (1.0 - fresnel) * (1.0 - u_parameters[2].z));
}
