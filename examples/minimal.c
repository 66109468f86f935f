/* minimal.c: one tetrahedron, one ray. */
#include <htree.h>

#include <math.h>
#include <stdio.h>

int main(void) {
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const htree_mesh mesh = {
        .positions = positions, .vertex_count = 4, .indices = indices, .triangle_count = 4};

    htree *tree = NULL;
    if (htree_build(&tree, &mesh, NULL) != HTREE_OK) {
        fprintf(stderr, "htree_build: %s\n", htree_error_text());
        return 1;
    }

    const htree_ray ray = {.org = {2, 2, 2}, .dir = {-1, -1, -1}, .tmax = INFINITY};
    htree_hit hit;
    if (htree_intersect(tree, &ray, 1, &hit, NULL) != HTREE_OK) {
        fprintf(stderr, "htree_intersect: %s\n", htree_error_text());
    } else if (hit.prim == HTREE_NONE) {
        printf("miss\n");
    } else {
        printf("triangle %u at t = %g, u = %g, v = %g\n", (unsigned)hit.prim, (double)hit.t,
               (double)hit.u, (double)hit.v);
    }
    htree_free(tree);
    return 0;
}
