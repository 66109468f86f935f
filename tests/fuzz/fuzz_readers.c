/* fuzz_readers.c: the readers of meshes and of scenes that the programs use. */
#include "aff.h"
#include "fuzz.h"
#include "ply.h"
#include "suite.h"

/* What a reader says about a file that it refuses: one line of plain characters. */
static void check_error(const char *error) {
    assert_true(error[0] != 0);
    for (; *error; ++error) assert_true(*error >= ' ' && *error <= '~');
}

/* ---- PLY ------------------------------------------------------------------------------------ */

static void run_ply(const uint8_t *bytes, size_t size) {
    char error[200] = "";
    shape s;
    if (!ply_read(fuzz_file("a.ply", bytes, size), &s, error, sizeof error)) {
        check_error(error);
        assert_true(s.positions == NULL && s.indices == NULL && s.triangle_count == 0);
        return;
    }
    assert_true(s.vertex_count <= size && s.triangle_count <= size);
    for (uint64_t i = 0; i < 3 * s.triangle_count; ++i) assert_true(s.indices[i] < s.vertex_count);
    const htree_mesh mesh = mesh_of(&s);
    htree_free(tree_of_kind(&mesh, HTREE_H));
    shape_free(&s);
}

#define PLY_PROPERTIES                                                                             \
    "element vertex 4\nproperty float x\nproperty double y\nproperty short z\n"                    \
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"

static void seed_ply(fuzz_emit *emit, void *data) {
    static const char ascii[] = "ply\nformat ascii 1.0\ncomment seed\n" PLY_PROPERTIES
                                "0 0 0\n1 .5 2\n-1e3 1e-40 3\n1 1 1\n3 0 1 2\n4 0 1 2 3\n";
    static const char beyond[] =
        "ply\nformat ascii 1.0\n" PLY_PROPERTIES "0 0 0\n1 0 0\n0 1 0\n1 1 1\n3 0 1 2\n3 1 2 4\n";
    static const char little[] = "ply\nformat binary_little_endian 1.0\n" PLY_PROPERTIES;
    static const char big[] = "ply\r\nformat binary_big_endian 1.0\n" PLY_PROPERTIES;
    static const char lists[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty list uint8 uint16 more\n"
        "property float32 x\nproperty float64 y\nproperty int8 z\nelement other 1\n"
        "property uchar c\nelement face 1\nproperty char flag\n"
        "property list ushort uint vertex_index\nend_header\n"
        "2 7 7 0 0 0\n0 1 0 0\n1 5 0 1 0\n9\n1 3 0 1 2\n";
    char binary[512];
    emit(data, ascii, sizeof ascii - 1);
    emit(data, lists, sizeof lists - 1);
    emit(data, beyond, sizeof beyond - 1);
    for (int i = 0; i < 2; ++i) {
        const char *const head = i ? big : little;
        const size_t length = strlen(head), rows = 4 * 14 + 2 * 13;
        memcpy(binary, head, length);
        memset(binary + length, 0, rows);
        binary[length + 4 * 14] = binary[length + 4 * 14 + 13] = 3;
        emit(data, binary, length + rows);
    }
}

const fuzz_target fuzz_ply = {"ply", run_ply, seed_ply};

/* ---- AFF ------------------------------------------------------------------------------------ */

/* Two moments of the film, each with a tree. */
static void play(const aff_scene *scene) {
    film f;
    aff_film(scene, &f);
    film_frame frame;
    memset(&frame, 0, sizeof frame);
    frame.positions = (float *)take(12 * f.vertex_count + 1);
    frame.cones = (cone *)take(f.cone_count * sizeof(cone) + 1);
    frame.boxes = (htree_box *)take(f.cone_count * sizeof(htree_box) + 1);
    for (uint64_t i = 0; i < 3 * f.triangle_count; ++i) assert_true(f.indices[i] < f.vertex_count);
    for (int i = 0; i < 2; ++i) {
        assert_true(f.pose(&f, 0.7 * i, 1, &frame));
        htree_mesh mesh;
        memset(&mesh, 0, sizeof mesh);
        mesh.positions = frame.positions;
        mesh.vertex_count = f.vertex_count;
        mesh.indices = f.indices;
        mesh.triangle_count = f.triangle_count;
        const htree_objects cones = {frame.boxes, f.cone_count, cone_intersect, frame.cones};
        mesh.objects = &cones;
        htree_free(tree_of_kind(&mesh, HTREE_WIDE));
    }
    free(frame.positions);
    free(frame.cones);
    free(frame.boxes);
}

static void run_aff(const uint8_t *bytes, size_t size) {
    const aff_options options = {(size & 1) != 0, (uint32_t)(size % 3)};
    char error[200] = "";
    aff_scene *scene = NULL;
    if (!aff_read(&scene, fuzz_file("a.aff", bytes, size), &options, error, sizeof error)) {
        check_error(error);
        assert_null(scene);
        return;
    }
    play(scene);
    aff_free(scene);
}

/* The scene of test_aff.c: all statements there are. */
static void seed_aff(fuzz_emit *emit, void *data) {
    static const char *const texts[] = {
        "% all\nb 0.1 0.2 0.3 v from 0 0 9 at 0 0 0 up 0 1 0 angle 40 hither 1 resolution 8 6\n"
        "am 1 1 1 l 1 2 3 1 1 1 l lamp 4 5 6 a -1 5 300\n"
        "fm .2 .2 .2 .8 .6 .4 0 0 0 20 0 0 f 1 0 0 .5 .5 3 0 1\n"
        "p 4 0 0 0 1 0 0 1 1 0 0 1 0 c 0 0 0 1 0 3 0 .5\n",
        "xs 2 2 2 0 0 1 90 10 0 0 { m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1\n"
        "texturecoords 2 wood.ppm 0 0 1 1 triangles 1 0 1 2 0 0 0 0 1 1 }\n"
        "pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 tt wood.ppm 0 0 0 0 0 1 0 0 1 0 0 1 0 0 1\n",
        "x mover { x turner { p 3 0 0 0 1 0 0 0 1 0 } }\n"
        "k mover { transl 3 -1 0 0 0 0 0 0 0 1 0 0 0 0 0 2 9 0 0 0 0 0 }\n"
        "k turner { rot 2 0 0 0 1 0 0 0 0 1 0 0 1 90 0 0 0 scale 1 0 1 2 3 0 0 0 }\n",
        "tpa 2 0 0 0 0 0 0 1 4 0 0 0 0 1 0 4 0 0 0 1 1 0 0 8 0 0 1 4 0 8 0 0 1 0 4 8 0 0 1\n",
        "i 0 a.aff",
    };
    for (size_t i = 0; i < COUNT_OF(texts); ++i) emit(data, texts[i], strlen(texts[i]));
}

const fuzz_target fuzz_aff = {"aff", run_aff, seed_aff};
