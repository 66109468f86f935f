/* test_aff.c: the reader of AFF scenes: what it counts, where it puts things at which time, and
 * that no text, however broken, does more than name the line that is wrong. */
#include "aff.h"
#include "spline.h"
#include "suite.h"

#include <math.h>
#include <unistd.h>

static char folder[64];

static void write_file(const char *name, const char *text, size_t length) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
}

/* Reads `name`; a failure must come with one line that names a file and a line. */
static aff_scene *read_scene(const char *name, const aff_options *options, char *error,
                             size_t size) {
    char path[128];
    aff_scene *scene = NULL;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    const bool ok = aff_read(&scene, path, options, error, size);
    assert_int_equal(ok, scene != NULL);
    if (!ok) {
        unsigned line = 0;
        const char *colon = strstr(error, ".aff:");
        assert_non_null(colon);
        assert_int_equal(sscanf(colon, ".aff:%u:", &line), 1);
        assert_true(line >= 1);
        assert_null(strchr(error, '\n'));
    }
    return scene;
}

static aff_scene *scene_of(const char *text, const aff_options *options) {
    char error[256] = "";
    write_file("main.aff", text, strlen(text));
    aff_scene *scene = read_scene("main.aff", options, error, sizeof error);
    if (!scene) fail_msg("%s", error);
    return scene;
}

static void must_fail(const char *text, const char *what) {
    const aff_options plain = {false, 0};
    char error[256] = "";
    write_file("main.aff", text, strlen(text));
    assert_null(read_scene("main.aff", &plain, error, sizeof error));
    if (!strstr(error, what)) fail_msg("'%s' does not say '%s'", error, what);
}

/* Vertex `index` of the scene at a time. */
static void vertex_at(const aff_scene *scene, double time, uint64_t index, double *out) {
    film f;
    film_frame frame;
    memset(&frame, 0, sizeof frame);
    aff_film(scene, &f);
    assert_true(index < f.vertex_count);
    frame.positions = (float *)take(f.vertex_count * 12);
    frame.cones = (cone *)take(f.cone_count * sizeof(cone) + 1);
    frame.boxes = (htree_box *)take(f.cone_count * sizeof(htree_box) + 1);
    assert_true(f.pose(&f, time, 2, &frame));
    for (uint64_t i = 0; i < 3 * f.triangle_count; ++i) assert_true(f.indices[i] < f.vertex_count);
    for (int k = 0; k < 3; ++k) out[k] = (double)frame.positions[3 * index + (uint64_t)k];
    free(frame.positions);
    free(frame.cones);
    free(frame.boxes);
}

static void must_be(const double *got, double x, double y, double z) {
    const double want[3] = {x, y, z};
    for (int i = 0; i < 3; ++i)
        if (!(fabs(got[i] - want[i]) < 1e-5))
            fail_msg("%g %g %g is not %g %g %g", got[0], got[1], got[2], x, y, z);
}

/* ---- A scene with everything ---------------------------------------------------------------- */

static const char part[] = "# a part\nm vertices 3 0 0 0 1 0 0 0 1 0 triangles 2 0 1 2 0 0 1\n";

static const char whole[] =
    "% everything that is read\n"
    "b 0.1 0.2 0.3 v from 0 0 9 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 6\n"
    "am 1 1 1 l 1 2 3 1 1 1 l lamp 4 5 6 a -1 5 300\n"
    "fm .2 .2 .2 .8 .6 .4 0 0 0 20 0 0\n"
    "f 1 0 0 .5 .5 3 0 1\n"
    "xs 2 2 2 0 0 1 90 10 0 0 { i 0 part.aff # not the end }\n"
    "  x mover { i 0 part.aff x turner { p 4 0 0 0 1 0 0 1 1 0 0 1 0 } } }\n"
    "m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1 texturecoords 2 wood.ppm 0 0 1 1\n"
    "  triangles 1 0 1 2 0 0 0 0 1 1\n"
    "pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1\n"
    "tt wood.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1\n"
    "c 0 0 0 1 0 3 0 .5\n"
    "tpa 2 0 0 0 0 0 0 1 4 0 0 0 0 1 0 4 0 0 0 1 1 0 0 8 0 0 1 4 0 8 0 0 1 0 4 8 0 0 1\n"
    "k mover { transl 4 -1 0 0 0 0 0 0 0 1 0 0 0 0 0 1 3 0 0 0 0 0 2 9 0 0 0 0 0 }\n"
    "k turner { rot 2 0 0 0 1 0 0 0 0 1 0 0 1 90 0 0 0 scale 1 0 1 2 3 0 0 0 }\n"
    "k camera { transl 1 0 1 2 3 0 0 0 rot 1 0 0 1 0 180 0 0 0 }\n";

static void test_counts(void **state) {
    (void)state;
    const aff_options plain = {false, 0}, all = {true, 3};
    aff_scene *scene = scene_of(whole, &plain);
    aff_counts c = aff_count(scene);
    assert_int_equal(c.meshes, 3);
    assert_int_equal(c.mesh_triangles, 3);
    assert_int_equal(c.dropped, 2);
    assert_int_equal(c.polygons, 3);
    assert_int_equal(c.polygon_triangles, 4);
    assert_int_equal(c.cones, 1);
    assert_int_equal(c.animated, 1);
    assert_int_equal(c.primitives, 3 + 3 + 1 + 1);
    aff_free(scene);
    scene = scene_of(whole, &all);
    c = aff_count(scene);
    film f;
    aff_film(scene, &f);
    assert_int_equal(c.dropped, 0);
    assert_int_equal(c.primitives, 5 + 3 + 1 + 64);
    assert_int_equal(f.triangle_count, 5 + 4 + 64);
    assert_int_equal(f.frames, 300);
    assert_true(f.from == -1 && f.to == 5 && f.light_count == 2);
    aff_free(scene);
}

static void test_places(void **state) {
    (void)state;
    const aff_options plain = {false, 0};
    double p[3];
    aff_scene *scene = scene_of(whole, &plain);
    vertex_at(scene, 0, 1, p); /* scaled by 2, turned x -> y, moved by 10 */
    must_be(p, 10, 2, 0);
    vertex_at(scene, 0, 3, p); /* mover at its key of time 0: x = 1 inside */
    must_be(p, 10, 2, 0);
    vertex_at(scene, 1, 3, p);
    must_be(p, 10, 6, 0);
    vertex_at(scene, 7, 3, p); /* rests after the last key but one */
    must_be(p, 10, 6, 0);
    vertex_at(scene, 0, 8, p); /* (1, 1, 0) of the polygon, scaled to (1, 2, 0) */
    must_be(p, 10 - 2 * 2, 2 * (1 + 1), 0);
    vertex_at(scene, 1, 7, p); /* (1, 0, 0) turned once more */
    must_be(p, 10 - 2, 2 * 3, 0);
    vertex_at(scene, 0.25, 20, p); /* corner b of the patch, a quarter of the way */
    must_be(p, 4, 0, 2);
    film f;
    camera view;
    aff_film(scene, &f);
    f.view(&f, 0, 2, &view);
    must_be(view.eye, 1, 2, 3);
    must_be(view.forward, 0, 0, 1);
    must_be(view.up, 0, 1, 0);
    must_be(view.right, -1, 0, 0);
    aff_free(scene);
}

/* ---- Splines -------------------------------------------------------------------------------- */

static spline_key key_at(double time, double x, double tension) {
    spline_key key;
    memset(&key, 0, sizeof key);
    key.time = time;
    key.value[0] = x;
    key.tension = tension;
    return key;
}

static double x_at(const spline *s, double time) {
    double p[3];
    spline_point(s, time, p);
    return p[0];
}

static void test_points(void **state) {
    (void)state;
    spline_key keys[5];
    for (int i = 0; i < 5; ++i) keys[i] = key_at(i, i * i, 0);
    spline s = {keys, 5};
    for (int i = 1; i < 4; ++i) assert_true(fabs(x_at(&s, i) - i * i) < 1e-12);
    /* A Catmull-Rom spline reproduces parabolas over even keys. */
    assert_true(fabs(x_at(&s, 1.5) - 2.25) < 1e-12);
    assert_true(x_at(&s, 0) == 1 && x_at(&s, 99) == 9);
    /* Full tension: no tangent, so the middle of a segment is the mean of its ends. */
    for (int i = 0; i < 5; ++i) keys[i].tension = 1;
    assert_true(fabs(x_at(&s, 1.5) - 2.5) < 1e-12);
    assert_true(fabs(x_at(&s, 1.25) - (1 + 3 * 0.15625)) < 1e-12);
    /* Bias 1 leaves with the step before the key, here none; bias -1 with the step after it. */
    for (int i = 0; i < 5; ++i) keys[i] = key_at(i, i == 3 ? 1 : 0, 0);
    keys[2].bias = 1;
    assert_true(fabs(x_at(&s, 2.5) - 0.5) < 1e-12);
    keys[2].bias = -1;
    assert_true(fabs(x_at(&s, 2.5) - 0.625) < 1e-12);
    /* Even motion stays even over uneven keys. */
    static const double times[5] = {0, 1, 3, 4, 9};
    for (int i = 0; i < 5; ++i) keys[i] = key_at(times[i], times[i], 0);
    for (double t = 1; t < 4; t += 0.1) assert_true(fabs(x_at(&s, t) - t) < 1e-12);
    s.count = 1;
    assert_true(x_at(&s, 5) == 0);
}

static void test_rotations(void **state) {
    (void)state;
    static const double axis[3] = {0, 0, 5};
    spline_key keys[6];
    spline s = {keys, 6};
    double q[4];
    for (int i = 0; i < 6; ++i) {
        keys[i] = key_at(i, 0, 0);
        spline_turn(&keys[i], axis, 170.0 * i);
    }
    spline_align(&s);
    /* Even turning about one axis stays even, through many whole turns. */
    for (double t = 1; t < 4; t += 0.05) {
        spline_rotation(&s, t, q);
        const double half = 85 * t * 3.14159265358979323846 / 180;
        assert_true(fabs(fabs(q[0] * cos(half) + q[3] * sin(half)) - 1) < 1e-9);
        assert_true(fabs(q[1]) < 1e-12 && fabs(q[2]) < 1e-12);
    }
    /* 350 degrees on is 10 degrees back. */
    for (int i = 0; i < 6; ++i) spline_turn(&keys[i], axis, 350.0 * i);
    spline_align(&s);
    spline_rotation(&s, 2.5, q);
    assert_true(fabs(fabs(q[0]) - cos(12.5 * 3.14159265358979323846 / 180)) < 1e-9);
}

/* ---- Cones ---------------------------------------------------------------------------------- */

typedef struct thrown_cone {
    double base[3], top[3], r0, r1;
    affine world;
    cone c;
    htree_box box;
} thrown_cone;

static thrown_cone throw_cone(dice *d) {
    thrown_cone t;
    double scale[3], move[3], axis[3];
    spline_key turn;
    for (int k = 0; k < 3; ++k) {
        t.base[k] = (double)dice_between(d, -1, 1);
        t.top[k] = (double)dice_between(d, -1, 1);
        scale[k] = (double)dice_between(d, 0.3f, 2);
        move[k] = (double)dice_between(d, -3, 3);
        axis[k] = (double)dice_between(d, -1, 1);
    }
    t.r0 = (double)dice_unit(d);
    t.r1 = (double)dice_unit(d);
    spline_turn(&turn, axis, 77);
    t.world = affine_from(scale, turn.value, move);
    assert_true(cone_place(&t.c, &t.box, &t.world, t.base, t.r0, t.top, t.r1));
    return t;
}

/* On the surface a point's distance from the axis is the radius at its height. */
static void must_be_on_cone(const thrown_cone *t, const double *point) {
    affine inverse = affine_identity();
    double local[3], length = 0, height = 0, away = 0;
    assert_true(affine_invert(&t->world, &inverse));
    affine_point(&inverse, point, local);
    for (int k = 0; k < 3; ++k) {
        const double along = t->top[k] - t->base[k];
        length += along * along;
        height += (local[k] - t->base[k]) * along;
        assert_true(point[k] >= (double)t->box.lo[k] - 1e-4);
        assert_true(point[k] <= (double)t->box.hi[k] + 1e-4);
    }
    height /= length;
    for (int k = 0; k < 3; ++k) {
        const double side = local[k] - t->base[k] - height * (t->top[k] - t->base[k]);
        away += side * side;
    }
    assert_true(height > -1e-4 && height < 1 + 1e-4);
    assert_true(fabs(sqrt(away) - (t->r0 + (t->r1 - t->r0) * height)) < 1e-4);
}

static void test_cones(void **state) {
    (void)state;
    dice d = {7};
    uint64_t hits = 0;
    for (int i = 0; i < 20000; ++i) {
        thrown_cone t = throw_cone(&d);
        htree_ray ray;
        htree_hit hit;
        for (int k = 0; k < 3; ++k) {
            ray.org[k] = dice_between(&d, -5, 5);
            ray.dir[k] = (float)t.world.m[k][3] - ray.org[k] + dice_unit(&d);
        }
        ray.tmin = 0;
        ray.tmax = INFINITY;
        if (!cone_intersect(&t.c, 0, &ray, &hit)) continue;
        ++hits;
        double point[3];
        for (int k = 0; k < 3; ++k)
            point[k] = (double)ray.org[k] + (double)hit.t * (double)ray.dir[k];
        must_be_on_cone(&t, point);
    }
    say("%llu of 20000 rays hit a cone", (unsigned long long)hits);
    assert_true(hits > 1000);
}

/* ---- Broken texts --------------------------------------------------------------------------- */

static void test_errors(void **state) {
    (void)state;
    must_fail("b 0 0 0\nq 1 2", "main.aff:2: 'q' is no statement");
    must_fail("b 0 0\n", "the file ends where a background's colour");
    must_fail("p 2 0 0 0 1 1 1", "main.aff:1: '2'");
    must_fail("m vertices 1 0 0 0\ntriangles 1\n0 0 1", "main.aff:3: '1' where a vertex");
    must_fail("m triangles 1 0 0 0", "without vertices");
    must_fail("l 1 2 nan", "'nan'");
    must_fail("xs 1 1 1 0 0 1 0 0 0 0 {", "where '}' should be");
    must_fail("}", "'}' is no statement");
    must_fail("\n\n i 0 missing.aff", "main.aff:3: ");
    must_fail("i 0 main.aff", "includes itself");
    must_fail("k a { transl 1 0 0 0 0 0 0 0 blink 3 }", "transl, rot, scale");
    must_fail("m vertices 4294967295 1 2 3", "'4294967295' where a number of entries");
    char deep[2048] = "";
    for (int i = 0; i < 100; ++i) strcat(deep, "x a { ");
    must_fail(deep, "inside each other");
    /* Two files that include each other. */
    write_file("other.aff", "i 0 main.aff", 12);
    must_fail("i 0 other.aff", "other.aff:1: ");
}

static uint64_t try_text(const char *text, size_t length) {
    const aff_options options = {false, 1};
    char error[256] = "";
    char *exact = (char *)take(length + 1); /* as long as it is, for the sanitizer */
    memcpy(exact, text, length);
    write_file("main.aff", exact, length);
    free(exact);
    aff_scene *scene = read_scene("main.aff", &options, error, sizeof error);
    if (scene) {
        double p[3];
        film f;
        aff_film(scene, &f);
        if (f.vertex_count > 0) vertex_at(scene, 0.5, 0, p);
    }
    aff_free(scene);
    return scene != NULL;
}

static void test_broken(void **state) {
    (void)state;
    const size_t length = sizeof whole - 1;
    uint64_t read = 0;
    for (size_t i = 0; i <= length; ++i) read += try_text(whole, i);
    dice d = {11};
    const uint64_t flips = scaled(20000);
    for (uint64_t i = 0; i < flips; ++i) {
        char text[sizeof whole];
        memcpy(text, whole, sizeof whole);
        for (uint32_t k = 1 + dice_below(&d, 3); k > 0; --k)
            text[dice_below(&d, (uint32_t)length)] = (char)dice_u32(&d);
        read += try_text(text, length);
    }
    say("%llu prefixes and %llu broken texts, %llu of them read", (unsigned long long)length + 1,
        (unsigned long long)flips, (unsigned long long)read);
}

/* ---- Runs ----------------------------------------------------------------------------------- */

static int set_up(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/htree-aff-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    write_file("part.aff", part, sizeof part - 1);
    return 0;
}

static int clean_up(void **state) {
    static const char *const names[] = {"main.aff", "part.aff", "other.aff"};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(names); ++i) {
        char path[128];
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        remove(path);
    }
    return rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts), cmocka_unit_test(test_places),
        cmocka_unit_test(test_points), cmocka_unit_test(test_rotations),
        cmocka_unit_test(test_cones),  cmocka_unit_test(test_errors),
        cmocka_unit_test(test_broken),
    };
    return cmocka_run_group_tests(tests, set_up, clean_up);
}
