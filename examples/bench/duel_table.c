#include "duel_table.h"

#include "figures.h"
#include "rows.h"

#include <math.h>

static bool has(const duel *d, contender_place place) {
    for (uint32_t i = 0; i < d->count; ++i)
        if (d->all[i].place == place) return true;
    return false;
}

/* ---- Builds --------------------------------------------------------------------------------- */

/* Of packets there is the frame alone: the build is their peer's. */
static void print_build(FILE *out, const contender *c, double triangles) {
    const bool builds = contender_builds(c);
    fprintf(out, "%-24s", c->name);
    for (int way = BUILD_FRESH; way >= BUILD_REFIT; --way)
        rows_print_number(out, 8, 1,
                          builds ? 1e9 * c->build_seconds[way] / triangles : (double)NAN);
    rows_print_number(out, 8, 1, c->bytes ? (double)c->bytes / triangles : (double)NAN);
    rows_print_number(out, 8, 1, c->peak ? (double)c->peak / triangles : (double)NAN);
    rows_print_number(out, 9, 2, 1e3 * c->frame_seconds[BUILD_FRESH]);
    rows_print_number(out, 9, 2, 1e3 * c->frame_seconds[BUILD_WARM]);
}

static void print_builds(FILE *out, const duel *d, uint64_t triangles) {
    const bool device = has(d, PLACE_DEVICE);
    fprintf(out, "\n%-24s %8s %8s %8s %8s %8s %9s %9s%s\n", "Build, ns a triangle", "fresh", "warm",
            "refit", "B/tri", "peak", "T_T[ms]", "warm T_T", device ? " upload[s] compile[s]" : "");
    for (uint32_t i = 0; i < d->count; ++i) {
        const contender *c = &d->all[i];
        const bool up = c->place == PLACE_DEVICE;
        print_build(out, c, (double)triangles);
        if (device) {
            rows_print_number(out, 9, 4, up ? c->upload_seconds : (double)NAN);
            rows_print_number(out, 10, 4, up ? c->compile_seconds : (double)NAN);
        }
        fputc('\n', out);
    }
    fprintf(out, "  fresh: a new handle or scene; warm: update or re-commit of the same; B/tri: "
                 "without the mesh; T_T: a build and the frame\n");
    if (device)
        fprintf(out, "  upload: until the kernel is proved; compile: what of it compiling and "
                     "proving took\n");
}

/* ---- Rays ----------------------------------------------------------------------------------- */

static void print_set_title(FILE *out, const duel *d, ray_set_name name) {
    char count[32];
    const ray_set *set = &d->sets[name];
    const double hits =
        set->count ? 100 * (double)d->all[0].rows[name].hits / (double)set->count : 0;
    fprintf(out, "\n%s: %s rays, %s, %.1f %% hit\n", ray_set_text(name),
            figures_commas(count, sizeof count, set->count), set->note, hits);
}

static void print_set(FILE *out, const duel *d, ray_set_name name) {
    const bool device = has(d, PLACE_DEVICE), other = has(d, PLACE_PEER);
    const double count = 1e-6 * (double)d->sets[name].count;
    fprintf(out, "%-24s %8s %6s", "Method", "Mrays/s", "+-%");
    if (device) fprintf(out, " %7s %10s %7s %9s", "x CPU", "on device", "host%", "first[s]");
    if (other) fprintf(out, " %9s", "x Embree");
    fprintf(out, " %8s\n", "differ");
    for (uint32_t i = 0; i < d->count; ++i) {
        const contender *c = &d->all[i];
        const contender_row *row = &c->rows[name];
        const bool timed = c->place == PLACE_DEVICE && row->kernel_seconds > 0;
        if (!contender_takes(c, &d->sets[name])) continue;
        fprintf(out, "%-24s", c->name);
        rows_print_number(out, 8, 2, count / row->seconds);
        rows_print_number(out, 6, 1, 50 * row->spread);
        if (device) {
            rows_print_number(out, 7, 2, row->versus_cpu);
            rows_print_number(out, 10, 2, timed ? count / row->kernel_seconds : (double)NAN);
            rows_print_number(out, 7, 1,
                              timed ? 100 * (1 - row->kernel_seconds / row->seconds) : (double)NAN);
            rows_print_number(out, 9, 4,
                              c->place == PLACE_DEVICE ? row->first_seconds : (double)NAN);
        }
        if (other) rows_print_number(out, 9, 2, row->versus_peer);
        fprintf(out, " %8llu\n", (unsigned long long)row->differ);
    }
}

static void print_legend(FILE *out, const duel *d) {
    fputc('\n', out);
    for (uint32_t i = 0; i < d->count; ++i) {
        if (d->all[i].place != PLACE_PEER) continue;
        fprintf(out, "  x Embree: speed against %s; x16: packets of 16, in its own layout\n",
                d->all[i].name);
        break;
    }
    if (has(d, PLACE_DEVICE))
        fprintf(out,
                "  x CPU: speed against the same kind there; on device: Mrays/s without the host; "
                "host%%: its part of the time\n");
    fprintf(
        out, "  +-%%: half the range of the rounds; differ: rays with another answer than %s's%s\n",
        d->all[0].name, has(d, PLACE_PEER) ? ", of peers: hit for miss, or t beyond rounding" : "");
}

void duel_print(FILE *out, const duel *d, const duel_title *title) {
    char count[32];
    fprintf(out, "\nScene %s - %s triangles, %s, seed %u, %u thread%s\n", title->scene,
            figures_commas(count, sizeof count, title->triangles), title->note, title->seed,
            title->threads, title->threads == 1 ? "" : "s");
    print_builds(out, d, title->triangles);
    for (int name = 0; name < RAY_SETS; ++name) {
        print_set_title(out, d, (ray_set_name)name);
        if (d->sets[name].count) print_set(out, d, (ray_set_name)name);
    }
    print_legend(out, d);
}
