// 3D Gaussians as quads in the image plane: four vertices a splat. See splat_draw.h.
layout(std430, binding = 1) readonly buffer Splats { float splats[]; };  // 13 each, see splat_draw.cpp
uniform mat4 u_view;
uniform mat4 u_projection;
uniform vec4 u_viewport;  // width and height in pixels
uniform uint u_first_instance;
flat out uint v_instance;
flat out vec4 v_color;  // linear; opacity at the centre
out vec2 v_offset;      // from the centre, standard deviations

// The covariance's footprint in square pixels: xx, xy, yy.
vec3 projected(mat3 covariance, vec3 centre) {
    vec2 focal = 0.5 * u_viewport.xy * vec2(u_projection[0][0], u_projection[1][1]);
    vec3 jacobian_x = vec3(focal.x, 0.0, 0.0);
    vec3 jacobian_y = vec3(0.0, focal.y, 0.0);
    if (u_projection[2][3] != 0.0) {
        float depth = -centre.z;
        // Far outside the image the local approximation would grow without bounds.
        vec2 limit = 1.3 * depth / vec2(u_projection[0][0], u_projection[1][1]);
        vec2 at = clamp(centre.xy, -limit, limit);
        jacobian_x = focal.x / depth * vec3(1.0, 0.0, at.x / depth);
        jacobian_y = focal.y / depth * vec3(0.0, 1.0, at.y / depth);
    }
    mat3 to_world = transpose(mat3(u_view));
    vec3 x = to_world * jacobian_x;
    vec3 y = to_world * jacobian_y;
    return vec3(dot(x, covariance * x), dot(x, covariance * y), dot(y, covariance * y));
}

void main() {
    v_instance = u_first_instance + uint(gl_InstanceID);
    int at = 13 * (gl_VertexID / 4);
    vec2 corner = vec2(float(gl_VertexID & 1), float((gl_VertexID >> 1) & 1)) * 2.0 - 1.0;
    vec3 centre = vec3(splats[at], splats[at + 1], splats[at + 2]);
    float xx = splats[at + 3], xy = splats[at + 4], xz = splats[at + 5];
    float yy = splats[at + 6], yz = splats[at + 7], zz = splats[at + 8];
    v_color = vec4(splats[at + 9], splats[at + 10], splats[at + 11], splats[at + 12]);
    vec3 in_camera = (u_view * vec4(centre, 1.0)).xyz;
    vec4 clip = u_projection * vec4(in_camera, 1.0);
    // Standard deviations at which alpha falls to 1/255.
    float reach = sqrt(2.0 * max(log(255.0 * v_color.a), 0.0));
    v_offset = corner * reach;
    if (clip.w <= 0.0 || reach == 0.0) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    vec3 footprint = projected(mat3(xx, xy, xz, xy, yy, yz, xz, yz, zz), in_camera);
    float a = footprint.x + 0.3;
    float c = footprint.z + 0.3;
    float middle = 0.5 * (a + c);
    float radius = length(vec2(0.5 * (a - c), footprint.y));
    // The form of the first eigenvector that does not cancel.
    vec2 axis = a >= c ? vec2(0.5 * (a - c) + radius, footprint.y) : vec2(footprint.y, 0.5 * (c - a) + radius);
    axis = radius > 0.0 ? normalize(axis) : vec2(1.0, 0.0);
    vec2 deviation = sqrt(max(vec2(middle + radius, middle - radius), 0.3));
    vec2 pixels = axis * (deviation.x * v_offset.x) + vec2(-axis.y, axis.x) * (deviation.y * v_offset.y);
    gl_Position = vec4(clip.xyz / clip.w + vec3(2.0 * pixels / u_viewport.xy, 0.0), 1.0);
}
