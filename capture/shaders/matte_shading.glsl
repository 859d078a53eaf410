// Diffuse surface; v_color.a > 0 is the side of a checker's squares, in scene units.
flat in vec4 v_color;
in vec3 v_world;
in vec3 v_normal;
in vec3 v_to_eye;
uniform vec4 u_parameters[8];  // 0: direction towards the light

vec4 shade() {
    vec3 normal = normalize(v_normal);
    float light = 0.3 + 0.7 * max(dot(normal, u_parameters[0].xyz), 0.0);
    vec3 color = v_color.rgb;
    if (v_color.a > 0.0) {
        // Half a square off the axes, so that a surface in an axis plane is not on the border of two squares.
        vec3 square = floor(v_world / v_color.a + 0.5);
        if (mod(square.x + square.y + square.z, 2.0) > 0.5) color *= 0.45;
    }
    return vec4(color * light, 1.0);
}
