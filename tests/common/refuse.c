/* refuse.c: bad calls, and what they must leave behind. */
#include "refuse.h"

static uint64_t refused;

uint64_t refusals(void) {
    return refused;
}

htree_mesh good_mesh(void) {
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    htree_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = corners;
    mesh.vertex_count = 3;
    mesh.triangle_count = 1;
    return mesh;
}

void assert_refused(htree_status is, htree_status should) {
    assert_int_equal(is, should);
    assert_true(strlen(htree_error_text()) > 5);
    ++refused;
}

/* Makes the text of the last failure a known one, so that a stale text shows. */
void set_error_text(void) {
    (void)htree_get_bounds(NULL, NULL);
}

void assert_not_built(const htree_mesh *mesh, const htree_options *options, htree_status should) {
    htree *tree = (htree *)(uintptr_t)8;
    set_error_text();
    char before[256];
    (void)snprintf(before, sizeof before, "%s", htree_error_text());
    assert_refused(htree_build(&tree, mesh, options), should);
    assert_null(tree);
    if (mesh != NULL) assert_string_not_equal(before, htree_error_text());
}
