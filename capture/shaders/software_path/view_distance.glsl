// Distances from the eye, along the view's axis: |z| is 1 / |offset + slope d| of window depth d, or without the
// quotient in a parallel view. In metres.
uniform vec4 u_distance;  // offset, slope, 1 where the view is perspective, metres a scene unit

float view_distance(float depth) {
    precise float linear = u_distance.x + u_distance.y * depth;
    return abs(u_distance.z != 0.0 ? 1.0 / linear : linear);
}
