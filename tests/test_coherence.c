/* test_coherence.c: pictures are found in batches, by rows or by cells, and nothing is where none is.
 * White-box: asks lib/trace/coherence.c itself. */
#include "pictures.h"

#include "trace/coherence.h"

static uint64_t row_of(const picture *p) {
    const htree_box box = {{-1, -1, -1}, {1, 1, 1}};
    return ht_find_rows(p->rays, p->count, &box, 100).row;
}

static void rows_are_found(void **state) {
    static const uint32_t widths[] = {4, 5, 16, 31, 64, 100, 255, 256, 1024};
    const float eye[3] = {0.3f, 2, 5}, forward[3] = {-2 / 7.0f, -3 / 7.0f, -6 / 7.0f};
    dice d = {7};
    (void)state;
    for (uint32_t i = 0; i < COUNT_OF(widths); ++i) {
        const float step = 0.05f / (float)widths[i];
        picture p = picture_pinhole(widths[i], 40, i % 4, eye, forward, step);
        assert_int_equal(row_of(&p), widths[i]);
        if (widths[i] > 7) p.rays[7] = p.rays[1]; /* back, but no row */
        assert_int_equal(row_of(&p), widths[i]);
        picture_shuffle(&p, &d);
        assert_int_not_equal(row_of(&p), widths[i]);
        free(p.rays);
        p = picture_parallel(widths[i], 40, eye, forward, step);
        assert_int_equal(row_of(&p), widths[i]);
        free(p.rays);
    }
}

static void cells_are_found(void **state) {
    static const uint32_t widths[] = {32, 40, 104, 256, 1000};
    const float eye[3] = {0.3f, 2, 5}, forward[3] = {-2 / 7.0f, -3 / 7.0f, -6 / 7.0f};
    const htree_box box = {{-1, -1, -1}, {1, 1, 1}};
    (void)state;
    for (uint32_t i = 0; i < 2 * COUNT_OF(widths); ++i) {
        const uint32_t width = widths[i / 2], cell = 2 + i % 2;
        picture p = picture_pinhole(width, 40, i % 5, eye, forward, 0.05f / (float)width);
        picture_cells(&p, 1u << cell);
        const ht_rows rows = ht_find_rows(p.rays, p.count, &box, 100);
        assert_int_equal(rows.row, width);
        assert_int_equal(rows.count, 40);
        assert_int_equal(rows.cell, cell);
        free(p.rays);
    }
}

static void scattered_rays_have_no_rows(void **state) {
    picture p = picture_of(64, 64, 0);
    dice d = {3};
    (void)state;
    for (uint64_t i = 0; i < p.count; ++i) {
        const float org[3] = {0, 0, 0};
        float way[3];
        random_unit(&d, way);
        p.rays[i] = ray_through(org, way);
    }
    assert_int_equal(row_of(&p), 0);
    p.count = 20;
    assert_int_equal(row_of(&p), 0);
    free(p.rays);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_found),
        cmocka_unit_test(cells_are_found),
        cmocka_unit_test(scattered_rays_have_no_rows),
    };
    return cmocka_run_group_tests_name("coherence", tests, NULL, NULL);
}
