// What shade() may say about the surface besides colour and alpha; kept where the scene records materials.
vec3 surface_transmission = vec3(0.0);  // of the covered part, per channel
float surface_collimation = 1.0;
float surface_eta = 1.0;
vec3 surface_normal = vec3(0.0);  // world space, towards the viewer; zero: faces the camera
