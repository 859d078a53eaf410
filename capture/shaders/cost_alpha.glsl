// What remains of a fragment shader when only alpha is wanted: the compiler removes the rest.
layout(location = 0) out float o_alpha;

void main() { o_alpha = shade().a; }
