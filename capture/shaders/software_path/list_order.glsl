// Turns a pixel's list into arrival order. Where the driver keeps it, the list comes in backwards, and every node
// goes to the front.
void main() {
    uint place = uint(gl_FragCoord.y) * u_width + uint(gl_FragCoord.x);
    uint rest = heads[place];
    uint first = 0u;
    while (rest != 0u) {
        uint at = rest - 1u;
        rest = nodes_in_use[at].next;
        uint order = nodes_in_use[at].order;
        uint after = first;  // the node that is to follow
        uint before = 0u;
        while (after != 0u && nodes_in_use[after - 1u].order < order) {
            before = after;
            after = nodes_in_use[after - 1u].next;
        }
        nodes_in_use[at].next = after;
        if (before == 0u) first = at + 1u;
        else nodes_in_use[before - 1u].next = at + 1u;
    }
    heads[place] = first;
}
