// minimal.cpp: one tetrahedron, one ray.
#include <htree.hpp>

#include <cmath>
#include <cstdio>

int main() try {
    const float xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::uint32_t abc[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const ht::tree tree = ht::tree::build(ht::mesh(xyz, 4).indices(abc, 4));
    const ht::hit hit = tree.intersect(ht::ray{{2, 2, 2}, 0, {-1, -1, -1}, INFINITY});
    if (hit.prim == HTREE_NONE)
        std::puts("miss");
    else
        std::printf("triangle %u at t = %g\n", unsigned(hit.prim), double(hit.t));
} catch (const ht::error &why) {
    std::fprintf(stderr, "%s: %s\n", why.name(), why.what());
    return 1;
}
