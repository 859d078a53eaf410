// Moves the whole picture, so that another position than the centre of each pixel is sampled.
uniform vec4 u_shift;  // xy: in clip space

void main() {
    scene_main();
    gl_Position.xy += u_shift.xy * gl_Position.w;
}
