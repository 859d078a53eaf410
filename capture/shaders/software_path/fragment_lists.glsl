// Linked lists of each pixel's visible fragments. A technique's pass goes over them in arrival order:
//     for (uint n = first_node(pixel); n != 0u; n = node(n).next) ...
struct Node {
    float z;  // of the plane at the pixel's centre
    float r, g, b;  // premultiplied
    float alpha;
    uint primitive;      // with kBackFacing
    uint coverage_draw;  // visible samples, draw << 16
    uint order;          // of arrival
    float slope_x, slope_y;
    uint next;  // node, 0: none
    uint pixel;
};
// Node 0 is none; the first word of its place counts the nodes in use.
layout(std430, binding = 0) buffer Nodes { uint node_count; uint node_padding[11]; Node nodes_in_use[]; };
layout(std430, binding = 5) buffer Heads { uint heads[]; };
uniform uint u_width;

uint first_node(ivec2 pixel) { return heads[uint(pixel.y) * u_width + uint(pixel.x)]; }
Node node(uint n) { return nodes_in_use[n - 1u]; }
vec3 premultiplied_of(Node n) { return vec3(n.r, n.g, n.b); }
uint coverage_of(Node n) { return n.coverage_draw & 0xFFFFu; }
// The fragment that a node was made of, without its material.
Arrival arrival_of(Node n) {
    Arrival a;
    a.pixel = uvec2(n.pixel & 0xFFFFu, n.pixel >> 16);
    a.z = n.z;
    a.slope = vec2(n.slope_x, n.slope_y);
    a.premultiplied = premultiplied_of(n);
    a.alpha = n.alpha;
    a.primitive = n.primitive & ~kBackFacing;
    a.back = (n.primitive & kBackFacing) != 0u;
    a.draw = n.coverage_draw >> 16;
    a.coverage = coverage_of(n);
    a.order = n.order;
    a.transmission = vec3(0.0);
    a.collimation = 1.0;
    a.eta = 1.0;
    a.normal = vec3(0.0, 0.0, 1.0);
    return a;
}
// Turns a pixel's list round, to the latest arrival first; the new first node.
uint reversed(uint rest) {
    uint first = 0u;
    while (rest != 0u) {
        uint at = rest;
        rest = nodes_in_use[at - 1u].next;
        nodes_in_use[at - 1u].next = first;
        first = at;
    }
    return first;
}
