/* soak.c: soak FOLDER SECONDS: what the tests do, for hours and with new seeds. Every round has a number,
 * which is its seed; FOLDER/state holds the next one and what was counted, so that a soak goes on where
 * the last one ended, and FOLDER/log a line a minute.
 *
 * A worker does the rounds. Where it dies, of a failed assertion, a signal or a round that takes ten
 * minutes, the round is a failure: its number is printed, and a new worker goes on with the next. */
#define _DEFAULT_SOURCE
#include "fuzz.h"
#include "oracle.h"
#include "pictures.h"
#include "rays.h"
#include "saved.h"

#include <math.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <fcntl.h>
#include <time.h>
#include <unistd.h>

enum { MINUTE = 60, ROUND_LIMIT = 10 * MINUTE };

typedef struct totals {
    uint64_t round; /* the one that is under way, or next */
    uint64_t seconds;
    uint64_t oracle_rays, aimed_rays, trees, inputs, same_files, picture_rays;
    uint64_t failures, last_failure;
    uint64_t first_pages, pages; /* resident: of a worker after its first minute, and now */
    uint64_t enough;             /* the worker is to end after its round */
} totals;

/* Shared by the worker and its watcher, and kept in the file. */
static totals *all;

static uint64_t resident_pages(void) {
    unsigned long size = 0, resident = 0;
    FILE *const file = fopen("/proc/self/statm", "r");
    if (file == NULL) return 0;
    if (fscanf(file, "%lu %lu", &size, &resident) != 2) resident = 0;
    fclose(file);
    return resident;
}

static htree_options any_options(dice *d, htree_kind kind) {
    static const float cells[] = {1.0f / 64, 0.25f, 0.5f, 1, 4, 64};
    htree_options options = options_of(kind);
    options.threads = dice_below(d, 4);
    options.buckets = 2 + dice_below(d, 63);
    options.axes = dice_below(d, 2) ? 1 : 3;
    options.few_prims = 1 + dice_below(d, 200);
    options.cells_per_prim = cells[dice_below(d, COUNT_OF(cells))];
    options.flags = dice_below(d, 64) & (uint32_t)~HTREE_STRICT;
    if (options.flags & HTREE_COMPACT) options.flags &= (uint32_t)~HTREE_LAZY;
    return options;
}

/* ---- Rounds --------------------------------------------------------------------------------- */

/* Any scene, any options, all kinds, against the oracle. */
static void compare_with_oracle(dice *d, uint32_t seed) {
    const char *const *const names = shape_names();
    uint32_t count = 0;
    while (names[count] != NULL) ++count;
    shape s = shape_of(names[dice_below(d, count)], 1u << dice_below(d, 12), seed);
    const float scale = ldexpf(1, (int)dice_below(d, 100) - 60);
    const float move = dice_below(d, 3) == 0 ? dice_between(d, -3e5f, 3e5f) : 0;
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i)
        s.positions[i] = s.positions[i] * scale + move;
    const htree_mesh mesh = mesh_of(&s);
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        const htree_options options = any_options(d, kind);
        htree *const tree = tree_of(&mesh, &options);
        oracle_compare(tree, &mesh, 400, seed);
        htree_free(tree);
        ++all->trees;
        all->oracle_rays += 400;
    }
    shape_free(&s);
}

/* An edge or a vertex, up to 3 ulp off. */
static void aim(const htree_mesh *mesh, dice *d, float *out) {
    const uint64_t i = dice_below(d, (uint32_t)mesh->triangle_count);
    const uint32_t side = dice_below(d, 3);
    const float *const a = mesh_corner(mesh, i, side);
    const float *const b = mesh_corner(mesh, i, (side + 1) % 3);
    const float s = dice_below(d, 3) == 0 ? 0 : dice_unit(d);
    for (int k = 0; k < 3; ++k)
        out[k] = nudged(a[k] + s * (b[k] - a[k]), (int)dice_below(d, 7) - 3);
}

/* Far from the origin rounding leaves some triangles without area: what they closed is open. */
static bool is_closed(const htree_mesh *mesh) {
    oracle o = oracle_of(mesh);
    const bool closed = o.degenerate == 0;
    oracle_free(&o);
    return closed;
}

/* From about the middle of a sphere outwards, and from outside to the middle. */
static void aim_at_edges(dice *d, uint32_t seed) {
    enum { RAYS = 4096 };
    static htree_ray rays[RAYS];
    static uint8_t any[RAYS];
    shape s = shape_of("sphere", 50 + dice_below(d, 5000), seed);
    float scale[3], middle[3];
    for (int k = 0; k < 3; ++k) {
        scale[k] = ldexpf(1 + dice_unit(d), (int)dice_below(d, 6));
        middle[k] = dice_below(d, 2) ? 0 : dice_between(d, -3e5f, 3e5f);
    }
    for (uint64_t i = 0; i < 3 * s.vertex_count; ++i)
        s.positions[i] = s.positions[i] * scale[i % 3] + middle[i % 3];
    const htree_mesh mesh = mesh_of(&s);
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE && is_closed(&mesh); ++kind) {
        const htree_options options = any_options(d, kind);
        htree *const tree = tree_of(&mesh, &options);
        for (uint32_t i = 0; i < RAYS; ++i) {
            float target[3], inside[3];
            aim(&mesh, d, target);
            for (int k = 0; k < 3; ++k)
                inside[k] = middle[k] + 0.2f * scale[k] * dice_between(d, -1, 1);
            rays[i] = ray_through(inside, target);
            if (i % 2) continue;
            /* From well beyond the target, and only to where it is inside. */
            for (int k = 0; k < 3; ++k)
                target[k] = inside[k] + ldexpf(target[k] - inside[k], 1 + (int)(i % 8));
            rays[i] = ray_through(target, inside);
            rays[i].tmax = 1;
        }
        assert_int_equal(htree_occluded(tree, rays, RAYS, any, NULL), HTREE_OK);
        for (uint32_t i = 0; i < RAYS; ++i) assert_int_equal(any[i], 1);
        htree_free(tree);
        ++all->trees;
        all->aimed_rays += RAYS;
    }
    shape_free(&s);
}

/* Rays that agree with their neighbours, together and one by one. */
static void compare_pictures(dice *d, uint32_t seed) {
    static const char *const names[] = {"knot", "city", "terrain", "soup", "slivers"};
    shape s = shape_of(names[dice_below(d, COUNT_OF(names))], 1u << dice_below(d, 15), seed);
    const htree_mesh mesh = mesh_of(&s);
    const ray_target target = ray_target_of(&mesh);
    const htree_options options = any_options(d, HTREE_WIDE);
    htree *const tree = tree_of(&mesh, &options);
    float eye[3], forward[3];
    picture_view(&target, d, eye, forward);
    const uint32_t width = 4 + dice_below(d, 200), height = 1 + dice_below(d, 100);
    const float step = dice_between(d, 0.1f, 2) / (float)width;
    picture p = dice_below(d, 3)
                    ? picture_pinhole(width, height, dice_below(d, width), eye, forward, step)
                    : picture_parallel(width, height, eye, forward, step);
    if (dice_below(d, 3) == 0) picture_disturb(&p, d);
    htree_hit *const hits = (htree_hit *)take(p.count * sizeof *hits);
    uint8_t *const any = (uint8_t *)take(p.count);
    assert_int_equal(htree_intersect(tree, p.rays, p.count, hits, NULL), HTREE_OK);
    assert_int_equal(htree_occluded(tree, p.rays, p.count, any, NULL), HTREE_OK);
    for (uint64_t i = 0; i < p.count; ++i) {
        htree_hit alone;
        assert_int_equal(htree_intersect(tree, &p.rays[i], 1, &alone, NULL), HTREE_OK);
        assert_memory_equal(&hits[i], &alone, sizeof alone);
        assert_int_equal(any[i], alone.prim != HTREE_NONE);
    }
    all->picture_rays += p.count;
    ++all->trees;
    free(hits);
    free(any);
    free(p.rays);
    htree_free(tree);
    shape_free(&s);
}

/* Any bits are triangles, and all kinds say the same of them. */
static void compare_garbage(dice *d, uint32_t seed) {
    enum { MOST = 256 };
    static float xyz[9 * MOST];
    const uint32_t count = dice_below(d, MOST + 1);
    for (uint32_t i = 0; i < 9 * count; ++i) {
        const uint32_t bits = dice_u32(d);
        memcpy(&xyz[i], &bits, sizeof bits);
    }
    const htree_mesh mesh = plain_mesh(xyz, count);
    for (htree_kind kind = HTREE_UG; kind <= HTREE_WIDE; ++kind) {
        const htree_options options = any_options(d, kind);
        htree *const tree = tree_of(&mesh, &options);
        oracle_compare(tree, &mesh, 100, seed);
        htree_free(tree);
        ++all->trees;
        all->oracle_rays += 100;
    }
}

/* Whoever builds it, on any threads: the same file, and what is loaded from it gives it again. */
static void compare_files(dice *d, uint32_t seed) {
    shape s = shape_of("city", 1000 + dice_below(d, 30000), seed);
    const htree_mesh mesh = mesh_of(&s);
    const htree_kind kind = (htree_kind)(1 + dice_below(d, HTREE_WIDE));
    htree_options options = any_options(d, kind);
    options.flags &= ~(uint32_t)HTREE_LAZY;
    saved first = {NULL, 0};
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        options.threads = threads;
        htree *const tree = tree_of(&mesh, &options), *back = NULL;
        saved file = saved_of(tree);
        htree_free(tree);
        assert_int_equal(htree_load(&back, file.bytes, file.size, NULL), HTREE_OK);
        if (first.bytes == NULL) first = saved_of(back);
        assert_int_equal(file.size, first.size);
        assert_memory_equal(file.bytes, first.bytes, (size_t)first.size);
        htree_free(back);
        saved_free(&file);
        ++all->trees;
        ++all->same_files;
    }
    saved_free(&first);
    shape_free(&s);
}

static void fuzz(dice *d) {
    static uint8_t bytes[FUZZ_MOST_BYTES];
    fuzz_corpus c;
    uint32_t count = 0;
    while (fuzz_targets[count] != NULL) ++count;
    const fuzz_target *const target = fuzz_targets[dice_below(d, count)];
    fuzz_corpus_make(&c, target);
    for (int i = 0; i < 500; ++i) {
        fuzz_run(target, bytes, fuzz_mutate(&c, d, bytes));
        ++all->inputs;
    }
    fuzz_corpus_free(&c);
}

static void do_round(uint64_t number) {
    dice d = {number * UINT64_C(0x9e3779b97f4a7c15)};
    const uint32_t seed = dice_u32(&d);
    switch (number % 9) {
    case 0:
    case 1:
    case 2: compare_with_oracle(&d, seed); break;
    case 3:
    case 4: aim_at_edges(&d, seed); break;
    case 5: compare_garbage(&d, seed); break;
    case 6: compare_files(&d, seed); break;
    case 7: compare_pictures(&d, seed); break;
    default: fuzz(&d); break;
    }
}

/* ---- Worker and watcher --------------------------------------------------------------------- */

static int work(void) {
    const time_t start = time(NULL);
    all->first_pages = 0;
    while (!__atomic_load_n(&all->enough, __ATOMIC_RELAXED)) {
        do_round(all->round);
        ++all->round;
        all->pages = resident_pages();
        if (all->first_pages == 0 && time(NULL) >= start + MINUTE) all->first_pages = all->pages;
    }
    return 0;
}

static void write_line(FILE *log) {
    const double mib = (double)sysconf(_SC_PAGESIZE) / 1048576;
    const uint64_t first = all->first_pages ? all->first_pages : all->pages;
    char line[400];
    snprintf(line, sizeof line,
             "%llu s, round %llu: %llu oracle rays, %llu aimed rays, %llu trees, %llu inputs, "
             "%llu same files, %llu rays of pictures, %.1f MiB (%+.1f), %llu failures\n",
             (unsigned long long)all->seconds, (unsigned long long)all->round,
             (unsigned long long)all->oracle_rays, (unsigned long long)all->aimed_rays,
             (unsigned long long)all->trees, (unsigned long long)all->inputs,
             (unsigned long long)all->same_files, (unsigned long long)all->picture_rays,
             mib * (double)all->pages, mib * ((double)all->pages - (double)first),
             (unsigned long long)all->failures);
    fputs(line, log);
    fflush(log);
    fputs(line, stdout);
    fflush(stdout);
}

static void note_failure(FILE *log, int status) {
    ++all->failures;
    all->last_failure = all->round;
    fprintf(log, "FAILED round %llu, worker ended with %#x\n", (unsigned long long)all->round,
            (unsigned)status);
    printf("FAILED round %llu: run it again by `soak FOLDER round %llu`\n",
           (unsigned long long)all->round, (unsigned long long)all->round);
    ++all->round;
}

/* Starts workers until the time is over, and writes a line a minute. The seconds are those that it lives
 * through: where a machine sleeps, or the soak is stopped for a while, no round has been slow. */
static void watch(FILE *log, uint64_t seconds) {
    pid_t worker = -1;
    uint64_t round = all->round, round_began = 0;
    all->enough = false;
    for (uint64_t second = 1; second <= seconds || worker > 0; ++second) {
        int status = 0;
        if (worker < 0) {
            worker = fork();
            if (worker == 0) exit(work());
            if (worker < 0) exit(1);
        }
        sleep(1);
        ++all->seconds;
        if (second % MINUTE == 0) write_line(log);
        __atomic_store_n(&all->enough, second >= seconds, __ATOMIC_RELAXED);
        if (round != all->round) {
            round = all->round;
            round_began = second;
        }
        if (second - round_began > ROUND_LIMIT) kill(worker, SIGALRM);
        if (waitpid(worker, &status, WNOHANG) != worker) continue;
        worker = -1;
        round_began = second;
        if (status != 0) note_failure(log, status);
    }
    write_line(log);
}

static totals *open_state(const char *folder) {
    char path[512];
    snprintf(path, sizeof path, "%s/state", folder);
    const int file = open(path, O_RDWR | O_CREAT, 0666);
    if (file < 0 || ftruncate(file, sizeof(totals)) != 0) return NULL;
    void *const state = mmap(NULL, sizeof(totals), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    close(file);
    return state == MAP_FAILED ? NULL : (totals *)state;
}

int main(int count, char **arguments) {
    if (count < 3) {
        fprintf(stderr, "soak FOLDER SECONDS, or soak FOLDER round NUMBER\n");
        return 2;
    }
    all = open_state(arguments[1]);
    char path[512];
    snprintf(path, sizeof path, "%s/log", arguments[1]);
    FILE *const log = all ? fopen(path, "a") : NULL;
    if (log == NULL) {
        fprintf(stderr, "soak: cannot write to %s\n", arguments[1]);
        return 2;
    }
    if (strcmp(arguments[2], "round") == 0) {
        do_round(strtoull(count > 3 ? arguments[3] : "0", NULL, 10));
        printf("the round passes\n");
        return 0;
    }
    watch(log, strtoull(arguments[2], NULL, 10));
    fclose(log);
    return all->failures > 0;
}
