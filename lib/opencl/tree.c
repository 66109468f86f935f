/* tree.c: a finished tree's arrays, copied to a device. */
#include "cl.h"

static htree_status file_of(htree_kind kind, ht_cl_file *file) {
    switch (kind) {
    case HTREE_UG: *file = HT_CL_UG; return HTREE_OK;
    case HTREE_KD: *file = HT_CL_KD; return HTREE_OK;
    case HTREE_BVH_MEDIAN:
    case HTREE_BVH_SAH: *file = HT_CL_BVH; return HTREE_OK;
    case HTREE_SKD:
    case HTREE_H:
    case HTREE_AH: *file = HT_CL_H; return HTREE_OK;
    case HTREE_WIDE: *file = HT_CL_WIDE; return HTREE_OK;
    default:
        return ht_cl_fail(HTREE_ERROR_UNSUPPORTED, 0, "no kernel walks trees of kind %ld",
                          (long)kind);
    }
}

/* An array of nothing is no buffer: kernels do not look at it. */
static htree_status upload_array(htree_cl *device, const void *data, uint64_t bytes,
                                 const char *what, cl_mem *out) {
    cl_int code = CL_SUCCESS;
    if (bytes == 0) return HTREE_OK;
    if (bytes > device->info.buffer_bytes) {
        return ht_cl_fail(HTREE_ERROR_LIMIT, 0,
                          "the tree's %s take %llu bytes, a buffer of the device at most %llu",
                          what, (unsigned long long)bytes,
                          (unsigned long long)device->info.buffer_bytes);
    }
    /* OpenCL does not write to what it copies from. */
    *out = device->api.CreateBuffer(device->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                                    (size_t)bytes, (void *)(uintptr_t)data, &code);
    return ht_cl_call(device, code, "clCreateBuffer");
}

static htree_status upload_arrays(htree_cl_tree *tree, const htree_view *view) {
    htree_cl *device = tree->device;
    const uint64_t triangle_bytes = view->prims ? 36 * (uint64_t)view->triangle_count : 0;
    ht_scene scene;
    memset(&scene, 0, sizeof scene);
    memcpy(scene.lo, view->bounds.lo, sizeof scene.lo);
    memcpy(scene.hi, view->bounds.hi, sizeof scene.hi);
    scene.prims = view->prims;
    if (view->grid) memcpy(&scene.grid, view->grid, sizeof scene.grid);
    HT_TRY(upload_array(device, &scene, sizeof scene, "shape", &tree->scene));
    HT_TRY(upload_array(device, view->nodes, view->node_bytes, "nodes", &tree->nodes));
    HT_TRY(upload_array(device, view->leaves, view->leaf_bytes, "leaves", &tree->leaves));
    /* The leaves of a wide tree hold the triangles themselves. */
    if (view->kind == HTREE_WIDE) return HTREE_OK;
    return upload_array(device, view->triangles, triangle_bytes, "triangles", &tree->triangles);
}

htree_status ht_cl_upload_for(htree_cl *device, ht_cl_program *program, const htree_view *view,
                              htree_cl_tree **out) {
    htree_cl_tree *tree = (htree_cl_tree *)ht_allocate(&device->memory, sizeof *tree);
    *out = NULL;
    if (!tree) return ht_cl_fail(HTREE_ERROR_MEMORY, 0, "out of memory");
    memset(tree, 0, sizeof *tree);
    tree->device = device;
    tree->program = program;
    ht_cl_retain(device);
    const htree_status status = upload_arrays(tree, view);
    if (status == HTREE_OK)
        *out = tree;
    else
        htree_cl_free(tree);
    return status;
}

htree_status htree_cl_upload(htree_cl_tree **out, htree_cl *device, const htree *tree) {
    htree_view view;
    ht_cl_file file = HT_CL_PROBE;
    ht_cl_program *program;
    if (!out) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "out is NULL");
    *out = NULL;
    if (!device) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "device is NULL");
    if (!tree) return ht_cl_fail(HTREE_ERROR_ARGUMENT, 0, "tree is NULL");
    view.size = sizeof view;
    if (htree_get_view(tree, &view) != HTREE_OK)
        return ht_cl_fail(HTREE_ERROR_UNSUPPORTED, 0,
                          "libhtree and libhtree_cl are of different versions");
    if (view.object_count) {
        return ht_cl_fail(HTREE_ERROR_UNSUPPORTED, 0,
                          "the tree holds user objects, whose callback a device cannot call");
    }
    HT_TRY(ht_cl_alive(device));
    HT_TRY(file_of(view.kind, &file));
    HT_TRY(ht_cl_get_program(device, file, view.stack, &program));
    return ht_cl_upload_for(device, program, &view, out);
}

void htree_cl_free(htree_cl_tree *tree) {
    if (!tree) return;
    htree_cl *device = tree->device;
    const cl_mem buffers[] = {tree->scene, tree->nodes, tree->triangles, tree->leaves};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; ++i) {
        if (buffers[i]) device->api.ReleaseMemObject(buffers[i]);
    }
    ht_release(&device->memory, tree, sizeof *tree);
    ht_cl_release(device);
}
