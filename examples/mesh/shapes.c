/* shapes.c: the built-in scenes. Each is chosen for what it does to a hierarchy: closed surfaces
 * show leaks, needles and huge boxes defeat splitting planes, coplanar copies force ties. Makers
 * allocate exact sizes first and then append; geometry is computed in double and rounded once. */
#include "shapes.h"

#include "shape_build.h"

#include <string.h>

typedef bool (*shape_maker)(shape *s, uint64_t triangles, uint32_t seed);

/* ---- Closed surfaces ------------------------------------------------------------------------ */

static bool make_ball(shape *s, uint64_t triangles, const double *origin, double radius) {
    /* stacks * 2 slices: 4 k (k - 1) triangles. */
    const uint64_t stacks = at_least(root((double)triangles / 4 + 0.25), 2), slices = 2 * stacks;
    double(*profile)[2] = (double(*)[2])malloc((size_t)(stacks + 1) * sizeof *profile);
    const bool ok = profile && reserve(s, (stacks - 1) * slices + 2, 2 * slices * (stacks - 1));
    for (uint64_t i = 0; ok && i <= stacks; ++i) {
        const double turn = 0.5 * (double)i / (double)stacks;
        profile[i][0] = sin_turns(turn);
        profile[i][1] = -cos_turns(turn);
    }
    if (ok) add_lathe(s, (const double(*)[2])profile, stacks + 1, slices, origin, radius);
    free(profile);
    return ok;
}

static bool make_sphere(shape *s, uint64_t triangles, uint32_t seed) {
    static const double origin[3] = {0, 0, 0};
    (void)seed;
    return make_ball(s, triangles, origin, 1);
}

/* At this distance a float resolves 1/64: rounding in the walk or the test shows at once. */
static bool make_far(shape *s, uint64_t triangles, uint32_t seed) {
    static const double origin[3] = {148376, 1234, -223423};
    (void)seed;
    return make_ball(s, triangles, origin, 1000);
}

/* Figures of 264 triangles on a sunflower spiral that thins out towards the rim of a wide floor. */
static bool make_crowd(shape *s, uint64_t triangles, uint32_t seed) {
    static const double figure[13][2] = {
        {0, 0},     {.38, 0},   {.40, .08}, {.30, .16}, {.27, .26},  {.16, .42}, {.12, .66},
        {.22, .72}, {.12, .78}, {.22, .87}, {.25, .98}, {.17, 1.11}, {0, 1.16}};
    const uint64_t slices = 12, each = 2 * slices * 11, count = at_least(triangles / each, 1);
    random_stream random = random_start(seed);
    if (!reserve(s, 4 + count * (slices * 11 + 2), 2 + count * each)) return false;
    const double rim = 2.2 * sqrt((double)count) + 2;
    for (int i = 0; i < 4; ++i) add_vertex(s, i % 3 ? rim : -rim, 0, i < 2 ? rim : -rim);
    add_quad(s, 0, 1, 2, 3);
    for (uint64_t i = 0; i < count; ++i) {
        const double part = ((double)i + 0.5) / (double)count;
        const double r = 0.55 * sqrt((double)i + 0.5) * (1 + part * part * 2);
        const double turn = 0.6180339887498949 * (double)i;
        const double origin[3] = {r * sin_turns(turn), 0, r * cos_turns(turn)};
        add_lathe(s, figure, 13, slices, origin, random_range(&random, 0.75, 1.25));
    }
    return true;
}

/* ---- Torus knot ----------------------------------------------------------------------------- */

static void knot_point(double turn, double *p) {
    const double r = 1 + 0.42 * cos_turns(3 * turn);
    p[0] = r * cos_turns(2 * turn);
    p[1] = r * sin_turns(2 * turn);
    p[2] = 0.55 * sin_turns(3 * turn);
}

/* The Frenet frame by differences. It is a function of the curve alone, so the tube closes upon
 * itself without a seam: the (2, 3) knot is curved everywhere. */
static void knot_frame(double turn, double *p, double *normal, double *binormal) {
    double before[3], after[3], tangent[3], bend[3];
    knot_point(turn, p);
    knot_point(turn - 1e-3, before);
    knot_point(turn + 1e-3, after);
    for (int i = 0; i < 3; ++i) {
        tangent[i] = after[i] - before[i];
        bend[i] = after[i] - 2 * p[i] + before[i];
    }
    cross(tangent, bend, binormal);
    normalise(binormal);
    normalise(tangent);
    cross(binormal, tangent, normal);
}

/* A tube whose surface winds like a rope of five strands; whole windings keep it closed. */
static bool make_knot(shape *s, uint64_t triangles, uint32_t seed) {
    const double quads = (double)triangles / 2;
    const uint64_t around = at_least(root(quads / 10), 3);
    const uint64_t along = at_least((uint64_t)(quads / (double)around), 16);
    (void)seed;
    if (!reserve(s, along * around, 2 * along * around)) return false;
    for (uint64_t i = 0; i < along; ++i) {
        double p[3], normal[3], binormal[3];
        knot_frame((double)i / (double)along, p, normal, binormal);
        for (uint64_t j = 0; j < around; ++j) {
            const double v = (double)j / (double)around, u = (double)i / (double)along;
            const double r = 0.235 + 0.028 * cos_turns(5 * v + 24 * u);
            const double a = r * cos_turns(v), b = r * sin_turns(v);
            add_vertex(s, p[0] + a * normal[0] + b * binormal[0],
                       p[1] + a * normal[1] + b * binormal[1],
                       p[2] + a * normal[2] + b * binormal[2]);
        }
    }
    for (uint64_t i = 0; i < along; ++i) {
        const uint64_t low = i * around, high = (i + 1) % along * around;
        for (uint64_t j = 0; j < around; ++j) {
            const uint64_t k = (j + 1) % around;
            add_quad(s, low + j, low + k, high + k, high + j);
        }
    }
    return true;
}

/* ---- Height fields -------------------------------------------------------------------------- */

typedef double (*height_function)(double x, double z, uint32_t seed);

static bool make_field(shape *s, uint64_t triangles, uint32_t seed, height_function height) {
    const uint64_t n = root((double)triangles / 2), row = n + 1;
    if (!reserve(s, row * row, 2 * n * n)) return false;
    for (uint64_t i = 0; i <= n; ++i) {
        for (uint64_t j = 0; j <= n; ++j) {
            const double x = 2 * (double)j / (double)n - 1, z = 2 * (double)i / (double)n - 1;
            add_vertex(s, x, height(x, z, seed), z);
        }
    }
    for (uint64_t i = 0; i < n; ++i) {
        for (uint64_t j = 0; j < n; ++j) {
            const uint64_t a = i * row + j;
            add_quad(s, a, a + row, a + row + 1, a + 1);
        }
    }
    return true;
}

/* Random values at the integer points, blended by a curve without a kink. */
static double value_noise(double x, double z, uint32_t seed) {
    const double fx = floor(x), fz = floor(z), u = x - fx, v = z - fz;
    const uint64_t ix = (uint64_t)((int64_t)fx + 4096), iz = (uint64_t)((int64_t)fz + 4096);
    double corner[4];
    for (uint64_t i = 0; i < 4; ++i)
        corner[i] = unit_from_bits(hash_pair(seed, (ix + i % 2) << 32 | (iz + i / 2)));
    const double su = u * u * u * (u * (6 * u - 15) + 10), sv = v * v * v * (v * (6 * v - 15) + 10);
    const double near = corner[0] + (corner[1] - corner[0]) * su;
    const double far = corner[2] + (corner[3] - corner[2]) * su;
    return near + (far - near) * sv;
}

/* Ridges: the fold at the middle of the noise makes crests, and each octave is weighted by the one
 * before, so that valleys stay smooth. The lattice turns between octaves, to hide its axes. */
static double terrain_height(double x, double z, uint32_t seed) {
    double sum = 0, weight = 1, amplitude = 0.3, px = 1.7 * x + 7, pz = 1.7 * z + 3;
    for (uint32_t octave = 0; octave < 8; ++octave) {
        const double fold = 1 - fabs(2 * value_noise(px, pz, seed + octave) - 1);
        const double ridge = fold * fold * weight;
        sum += amplitude * ridge;
        weight = ridge < 0.5 ? 2 * ridge : 1;
        amplitude *= 0.43;
        const double turned = 1.6 * px - 1.2 * pz;
        pz = 1.2 * px + 1.6 * pz;
        px = turned;
    }
    return sum;
}

static bool make_terrain(shape *s, uint64_t triangles, uint32_t seed) {
    return make_field(s, triangles, seed, terrain_height);
}

/* Rings from five drops that fell into one pond. */
static double wave_height(double x, double z, uint32_t seed) {
    random_stream random = random_start(seed);
    double sum = 0;
    for (int i = 0; i < 5; ++i) {
        const double dx = x - random_range(&random, -1, 1), dz = z - random_range(&random, -1, 1);
        const double d = sqrt(dx * dx + dz * dz), rate = random_range(&random, 5, 11);
        sum += 0.05 * cos_turns(rate * d) / (1 + 3 * d);
    }
    return sum;
}

static bool make_waves(shape *s, uint64_t triangles, uint32_t seed) {
    return make_field(s, triangles, seed, wave_height);
}

/* ---- Boxes ---------------------------------------------------------------------------------- */

/* One block per cell. Heights follow 1 / u: most blocks are low, a few tower over everything. */
static bool make_city(shape *s, uint64_t triangles, uint32_t seed) {
    const uint64_t side = root(triangles > 26 ? (double)(triangles - 2) / 12 : 1);
    random_stream random = random_start(seed);
    if (!reserve(s, 4 + 8 * side * side, 2 + 12 * side * side)) return false;
    const double rim = 0.5 * (double)side + 1;
    for (int i = 0; i < 4; ++i) add_vertex(s, i % 3 ? rim : -rim, 0, i < 2 ? rim : -rim);
    add_quad(s, 0, 1, 2, 3);
    for (uint64_t i = 0; i < side * side; ++i) {
        const double x = (double)(i % side) - 0.5 * (double)side;
        const double z = (double)(i / side) - 0.5 * (double)side;
        const double u = random_unit(&random), slim = random_range(&random, 0.08, 0.26);
        const double deep = random_range(&random, 0.08, 0.26);
        const double lo[3] = {x + slim, 0, z + deep};
        const double hi[3] = {x + 1 - slim, 0.12 + 0.11 / (u + 0.012), z + 1 - deep};
        add_box(s, lo, hi);
    }
    return true;
}

/* ---- Loose triangles ------------------------------------------------------------------------ */

/* Edges shrink with N^(-1/3): every N covers about the same part of each triangle's surroundings.
 */
static bool make_soup(shape *s, uint64_t triangles, uint32_t seed) {
    if (!reserve(s, 3 * triangles, triangles)) return false;
    const double size = 0.9 * cube_root(1 / (double)at_least(triangles, 1));
    random_stream random = random_start(seed);
    for (uint64_t i = 0; i < triangles; ++i) {
        double centre[3], corner[3];
        for (int k = 0; k < 3; ++k) centre[k] = random_unit(&random);
        for (uint64_t j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) corner[k] = centre[k] + size * (random_unit(&random) - 0.5);
            add_vertex(s, corner[0], corner[1], corner[2]);
        }
        add_triangle(s, 3 * i, 3 * i + 1, 3 * i + 2);
    }
    return true;
}

/* Needles from one common vertex to points spread evenly over a sphere: boxes overlap near the
 * centre whatever the splits. */
static bool make_slivers(shape *s, uint64_t triangles, uint32_t seed) {
    if (!reserve(s, 1 + 2 * triangles, triangles)) return false;
    random_stream random = random_start(seed);
    add_vertex(s, 0, 0, 0);
    for (uint64_t i = 0; i < triangles; ++i) {
        const double y = 1 - (2 * (double)i + 1) / (double)triangles, r = sqrt(1 - y * y);
        const double turn = 0.6180339887498949 * (double)i;
        const double along[3] = {r * sin_turns(turn), y, r * cos_turns(turn)};
        const double length = random_range(&random, 0.85, 1), up[3] = {0, 1, 0};
        double side[3];
        cross(along, up, side);
        for (double w = -0.004; w < 0.005; w += 0.008)
            add_vertex(s, length * along[0] + w * side[0], length * along[1] + w * side[1],
                       length * along[2] + w * side[2]);
        add_triangle(s, 0, 2 * i + 1, 2 * i + 2);
    }
    return true;
}

/* Four floors of coplanar quads, in turn the whole floor and a shifted part of it. Coordinates are
 * multiples of 1/8, so that hits on one floor are equal to the bit and the lowest index must win.
 */
static bool make_stack(shape *s, uint64_t triangles, uint32_t seed) {
    if (!reserve(s, 2 * (triangles + 1), triangles + 1)) return false;
    random_stream random = random_start(seed);
    for (uint64_t i = 0; 2 * i < triangles; ++i) {
        const double y = 0.25 * (double)(i % 4), half = i / 4 % 2 ? 0.5 : 1;
        const double x = i / 4 % 2 ? floor(random_range(&random, -4, 5)) / 8 : 0;
        const double z = i / 4 % 2 ? floor(random_range(&random, -4, 5)) / 8 : 0;
        add_vertex(s, x - half, y, z - half);
        add_vertex(s, x - half, y, z + half);
        add_vertex(s, x + half, y, z + half);
        add_vertex(s, x + half, y, z - half);
        add_quad(s, 4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3);
    }
    s->triangle_count = triangles;
    return true;
}

/* Concentric triangles: corners (-a, 0, a), (a, -a, 0), (0, a, -a) with some axes mirrored. The
 * mean of the corners and the centre of the box are both exactly 0: no plane parts the centroids.
 */
static bool make_same(shape *s, uint64_t triangles, uint32_t seed) {
    if (!reserve(s, 3 * triangles, triangles)) return false;
    (void)seed;
    for (uint64_t i = 0; i < triangles; ++i) {
        const double a = ((double)i + 1) / (double)triangles;
        const double x = i & 1 ? -a : a, y = i & 2 ? -a : a;
        add_vertex(s, -x, 0, a);
        add_vertex(s, x, -y, 0);
        add_vertex(s, 0, y, -a);
        add_triangle(s, 3 * i, 3 * i + 1, 3 * i + 2);
    }
    return true;
}

static bool make_one(shape *s, uint64_t triangles, uint32_t seed) {
    (void)triangles, (void)seed;
    if (!reserve(s, 3, 1)) return false;
    add_vertex(s, -1, 0, 0);
    add_vertex(s, 1, 0, 0);
    add_vertex(s, 0, 1.5, 0);
    add_triangle(s, 0, 1, 2);
    return true;
}

static bool make_none(shape *s, uint64_t triangles, uint32_t seed) {
    (void)triangles, (void)seed;
    return reserve(s, 0, 0);
}

/* ---- The table ------------------------------------------------------------------------------ */

static const struct {
    const char *name, *text;
    uint64_t triangles;
    shape_maker make;
} scene_table[] = {
    {"knot", "closed tube along a torus knot, wound like a rope", 100000, make_knot},
    {"terrain", "ridged mountains over a grid", 200000, make_terrain},
    {"waves", "rings on a pond, a gentle height field", 200000, make_waves},
    {"city", "many low blocks, a few towers, one huge floor", 30000, make_city},
    {"crowd", "small closed figures on a wide floor", 150000, make_crowd},
    {"sphere", "closed sphere, poles and all", 20000, make_sphere},
    {"soup", "random triangles in a cube", 20000, make_soup},
    {"slivers", "needles that share one vertex", 4000, make_slivers},
    {"stack", "coplanar quads, identical and overlapping", 400, make_stack},
    {"same", "triangles with one centroid for all", 60, make_same},
    {"far", "sphere far from the origin, at 148376 1234 -223423", 5000, make_far},
    {"one", "one triangle", 1, make_one},
    {"none", "no triangle", 0, make_none},
};

enum { SCENE_COUNT = sizeof scene_table / sizeof *scene_table };

static int scene_find(const char *name) {
    int i = 0;
    while (i < SCENE_COUNT && strcmp(name, scene_table[i].name) != 0) ++i;
    return i;
}

bool shape_make(shape *out, const char *name, uint64_t triangles, uint32_t seed) {
    const int scene = scene_find(name);
    memset(out, 0, sizeof *out);
    /* The bound keeps every product of sizes in the makers far from overflow. */
    if (scene < SCENE_COUNT && triangles <= UINT64_C(1) << 30 &&
        scene_table[scene].make(out, triangles, seed))
        return true;
    shape_free(out);
    return false;
}

void shape_free(shape *s) {
    free(s->positions);
    free(s->indices);
    memset(s, 0, sizeof *s);
}

const char *const *shape_names(void) {
    /* As long as the table: the compiler refuses a longer list, and a shorter one ends in NULL. */
    static const char *const names[SCENE_COUNT + 1] = {
        "knot",    "terrain", "waves", "city", "crowd", "sphere", "soup",
        "slivers", "stack",   "same",  "far",  "one",   "none",   NULL};
    return names;
}

const char *shape_text(const char *name) {
    const int scene = scene_find(name);
    return scene < SCENE_COUNT ? scene_table[scene].text : NULL;
}

uint64_t shape_default_triangles(const char *name) {
    const int scene = scene_find(name);
    return scene < SCENE_COUNT ? scene_table[scene].triangles : 0;
}
