/* cl_compare.c: rays on the first device against the CPU, for simulators of devices: the batches of
 * known answers that libhtree_cl asks for would take them minutes, so the linker puts an empty
 * proof in their place.
 *
 *     cl_compare KIND RAYS TRIANGLES     KIND: a kind of tree, or "probe" */
#include "cl_suite.h"
#include "rays.h"

#include "opencl/cl.h"

htree_status __wrap_ht_cl_prove(htree_cl *device, ht_cl_file file, ht_cl_program *program);

htree_status __wrap_ht_cl_prove(htree_cl *device, ht_cl_file file, ht_cl_program *program) {
    (void)device;
    (void)file;
    (void)program;
    return HTREE_OK;
}

/* By the kernel of the tree's kind, or by the probe's, which wants triangles alone. */
static htree_cl_tree *upload_for(htree_cl *device, const htree *tree, bool probe) {
    htree_cl_tree *uploaded = NULL;
    ht_cl_program *program = NULL;
    htree_view view;
    if (!probe) return upload(device, tree);
    view.size = sizeof view;
    assert_int_equal(htree_get_view(tree, &view), HTREE_OK);
    assert_cl_ok(ht_cl_get_program(device, HT_CL_PROBE, 0, &program));
    assert_cl_ok(ht_cl_upload_for(device, program, &view, &uploaded));
    return uploaded;
}

int main(int count, char **arguments) {
    if (count != 4) return 2;
    const bool probe = strcmp(arguments[1], "probe") == 0;
    const uint64_t rays = strtoull(arguments[2], NULL, 10);
    shape s = shape_of("knot", strtoull(arguments[3], NULL, 10), 1);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    htree *const tree = tree_of_kind(&mesh, probe ? HTREE_H : htree_kind_from_name(arguments[1]));
    htree_ray *const ray = (htree_ray *)take(rays * sizeof *ray);
    htree_hit *const hits = (htree_hit *)take(rays * sizeof *hits);
    htree_hit *const truth = (htree_hit *)take(rays * sizeof *truth);
    uint8_t *const any = (uint8_t *)take(rays);
    dice d = {9};
    rays_make_mixed(&target, &d, ray, rays);
    assert_int_equal(htree_intersect(tree, ray, rays, truth, NULL), HTREE_OK);
    htree_cl *const device = open_device(NULL);
    htree_cl_tree *const uploaded = upload_for(device, tree, probe);
    assert_cl_ok(htree_cl_intersect(uploaded, ray, rays, hits, NULL));
    assert_cl_ok(htree_cl_occluded(uploaded, ray, rays, any, NULL));
    uint64_t differences = hits_differ(hits, truth, rays);
    for (uint64_t i = 0; i < rays; ++i) differences += any[i] != (truth[i].prim != HTREE_NONE);
    printf("%s: %llu rays, %llu triangles, %llu differences\n", arguments[1],
           (unsigned long long)rays, (unsigned long long)s.triangle_count,
           (unsigned long long)differences);
    htree_cl_free(uploaded);
    htree_cl_close(device);
    htree_free(tree);
    shape_free(&s);
    free(ray);
    free(hits);
    free(truth);
    free(any);
    return differences != 0;
}
