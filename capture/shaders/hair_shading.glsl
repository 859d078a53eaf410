// Kajiya and Kay's strand shading with two shifted highlights, dimmed by the hair between strand and light.
flat in vec4 v_color;
in vec4 v_tangent;
in vec4 v_to_eye;
uniform vec4 u_parameters[8];  // 0: direction towards the light

vec4 shade() {
    vec3 tangent = normalize(v_tangent.xyz);
    vec3 to_eye = normalize(v_to_eye.xyz);
    float lit = v_tangent.w;
    float along_light = dot(tangent, u_parameters[0].xyz);
    float sine_light = sqrt(max(1.0 - along_light * along_light, 0.0));
    vec3 halfway = normalize(u_parameters[0].xyz + to_eye);
    float along_half = dot(tangent, halfway);
    float first = sqrt(max(1.0 - (along_half + 0.08) * (along_half + 0.08), 0.0));
    float second = sqrt(max(1.0 - (along_half - 0.12) * (along_half - 0.12), 0.0));
    float white = 0.22 * pow(first, 90.0);
    float tinted = 0.7 * pow(second, 22.0);
    vec3 color = v_color.rgb * (0.16 + lit * (0.75 * sine_light + tinted)) + vec3(lit * white);
    // The last fifth fades out.
    float alpha = v_color.a * min(1.0, 5.0 * (1.0 - v_to_eye.w) + 0.05);
    return vec4(color, alpha);
}
