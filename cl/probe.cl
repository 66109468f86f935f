/* probe.cl: every triangle is asked, in order: whether a device's arithmetic gives the CPU's bits,
 * before any structure is trusted to it. */

void walk_probe(__global const ht_scene *scene, __global const void *nodes,
                __global const float *triangles, __global const void *leaves, const ht_ray *r,
                ht_hit *hit, const bool any) {
    for (uint prim = 0; prim < scene->prims; ++prim) {
        if (ht_triangle_intersect(r, triangles, prim, hit) && any) return;
    }
}

HT_KERNELS(walk_probe)
