// Puts a fragment at the head of its pixel's list.
uniform uint u_capacity;
uniform vec4 u_rectangle;  // x, y, width, height: llvmpipe's points reach over the edges of the scissor

void main() {
    Arrival a = arrival();
    uint visible = visible_samples(a);
    vec2 place = vec2(a.pixel) - u_rectangle.xy;
    bool outside = any(lessThan(place, vec2(0.0))) || any(greaterThanEqual(place, u_rectangle.zw));
    if (visible == 0u || outside) discard;
    uint slot = atomicAdd(node_count, 1u);
    if (slot >= u_capacity) return;
    uint before = atomicExchange(heads[a.pixel.y * u_width + a.pixel.x], slot + 1u);
    nodes_in_use[slot] = Node(a.z, a.premultiplied.r, a.premultiplied.g, a.premultiplied.b, a.alpha,
                              a.primitive | (a.back ? kBackFacing : 0u), visible | (a.draw << 16), a.order,
                              a.slope.x, a.slope.y, before, a.pixel.x | (a.pixel.y << 16));
}
