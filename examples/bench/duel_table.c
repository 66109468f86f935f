#include "duel_table.h"

#include "figures.h"
#include "report.h"

#include <math.h>

/* Blank where there is nothing to say. */
static void print_number(FILE *out, int width, int digits, double x) {
    if (isfinite(x))
        fprintf(out, " %*.*f", width, digits, x);
    else
        fprintf(out, " %*s", width, "-");
}

static bool has(const duel *d, contender_place place) {
    for (uint32_t i = 0; i < d->count; ++i)
        if (d->all[i].place == place) return true;
    return false;
}

/* ---- Builds --------------------------------------------------------------------------------- */

static void print_builds(FILE *out, const duel *d, uint64_t triangles) {
    const bool device = has(d, PLACE_DEVICE);
    fprintf(out, "\n%-18s %9s %8s %8s%s\n", "Build", "T_C[s]", "Mtri/s", "MB",
            device ? " upload[s] compile[s]" : "");
    for (uint32_t i = 0; i < d->count; ++i) {
        const contender *c = &d->all[i];
        const double up = c->place == PLACE_DEVICE ? c->upload_seconds : (double)NAN;
        fprintf(out, "%-18s", c->name);
        print_number(out, 9, 4, c->build_seconds);
        print_number(out, 8, 2, 1e-6 * (double)triangles / c->build_seconds);
        print_number(out, 8, 1, c->bytes ? 1e-6 * (double)c->bytes : (double)NAN);
        if (device) {
            print_number(out, 9, 4, up);
            print_number(out, 10, 4, isnan(up) ? up : c->compile_seconds);
        }
        fputc('\n', out);
    }
    if (device)
        fprintf(out, "  upload: until the kernel is proved; compile: what of it compiling and "
                     "proving took\n");
}

/* ---- Rays ----------------------------------------------------------------------------------- */

static void print_set_title(FILE *out, const duel *d, const duel_title *title, ray_set_name name) {
    char count[32];
    const ray_set *set = &d->sets[name];
    const double hits =
        set->count ? 100 * (double)d->all[0].rows[name].hits / (double)set->count : 0;
    fprintf(out, "\n%s: %s rays, ", ray_set_text(name),
            figures_commas(count, sizeof count, set->count));
    if (name == RAYS_PRIMARY)
        fprintf(out, "%ux%u in tiles of %ux%u", title->wish.width, title->wish.height,
                title->wish.tile, title->wish.tile);
    else
        fprintf(out, "one a primary hit, cosine-distributed");
    if (name == RAYS_AMBIENT)
        fprintf(out, ", %g %% of the diagonal (%.4g) long: any hit", 100 * title->wish.reach,
                title->reach);
    else
        fprintf(out, ": closest hit");
    fprintf(out, ", %.1f %% hit\n", hits);
}

static void print_set(FILE *out, const duel *d, ray_set_name name) {
    const bool device = has(d, PLACE_DEVICE), other = has(d, PLACE_PEER);
    const double count = 1e-6 * (double)d->sets[name].count;
    fprintf(out, "%-18s %8s %6s", "Method", "Mrays/s", "+-%");
    if (device) fprintf(out, " %7s %10s %7s %9s", "x CPU", "on device", "host%", "first[s]");
    if (other) fprintf(out, " %9s", "x Embree");
    fprintf(out, " %8s\n", "differ");
    for (uint32_t i = 0; i < d->count; ++i) {
        const contender *c = &d->all[i];
        const contender_row *row = &c->rows[name];
        const bool timed = c->place == PLACE_DEVICE && row->kernel_seconds > 0;
        fprintf(out, "%-18s", c->name);
        print_number(out, 8, 2, count / row->seconds);
        print_number(out, 6, 1, 50 * row->spread);
        if (device) {
            print_number(out, 7, 2, row->versus_cpu);
            print_number(out, 10, 2, timed ? count / row->kernel_seconds : (double)NAN);
            print_number(out, 7, 1,
                         timed ? 100 * (1 - row->kernel_seconds / row->seconds) : (double)NAN);
            print_number(out, 9, 4, c->place == PLACE_DEVICE ? row->first_seconds : (double)NAN);
        }
        if (other) print_number(out, 9, 2, row->versus_peer);
        fprintf(out, " %8llu\n", (unsigned long long)row->differ);
    }
}

static void print_legend(FILE *out, const duel *d) {
    fputc('\n', out);
    if (has(d, PLACE_DEVICE))
        fprintf(out,
                "  x CPU: speed against the same kind there; on device: Mrays/s without the host; "
                "host%%: its part of the time\n");
    fprintf(out,
            "  +-%%: half the range of the rounds; differ: rays with another answer than %s's%s\n",
            d->all[0].name, has(d, PLACE_PEER) ? ", of peers: hit for miss" : "");
}

void duel_print(FILE *out, const duel *d, const duel_title *title) {
    char count[32];
    fprintf(out, "\nScene %s - %s triangles, %s, seed %u\n", title->scene,
            figures_commas(count, sizeof count, title->triangles), title->note, title->wish.seed);
    print_builds(out, d, title->triangles);
    for (int name = 0; name < RAY_SETS; ++name) {
        print_set_title(out, d, title, (ray_set_name)name);
        if (d->sets[name].count) print_set(out, d, (ray_set_name)name);
    }
    print_legend(out, d);
}

/* ---- JSON ----------------------------------------------------------------------------------- */

static void write_row(FILE *file, const duel *d, const duel_title *title, const contender *c,
                      ray_set_name name) {
    static const char *const places[] = {"cpu", "device", "peer"};
    const contender_row *row = &c->rows[name];
    const bool device = c->place == PLACE_DEVICE;
    const struct {
        const char *key;
        double value;
    } figures[] = {
        {"triangles", (double)title->triangles},
        {"count", (double)d->sets[name].count},
        {"hits", (double)row->hits},
        {"differ", (double)row->differ},
        {"build_seconds", c->build_seconds},
        {"bytes", c->bytes ? (double)c->bytes : (double)NAN},
        {"upload_seconds", device ? c->upload_seconds : (double)NAN},
        {"compile_seconds", device ? c->compile_seconds : (double)NAN},
        {"first_seconds", row->first_seconds},
        {"seconds", row->seconds},
        {"spread", row->spread},
        {"mrays", 1e-6 * (double)d->sets[name].count / row->seconds},
        {"kernel_seconds", device ? row->kernel_seconds : (double)NAN},
        {"versus_cpu", row->versus_cpu},
        {"versus_peer", row->versus_peer},
    };
    fputs("{\"scene\": ", file);
    report_write_string(file, title->scene);
    fprintf(file, ", \"rays\": \"%s\", \"method\": \"%s\", \"place\": \"%s\"", ray_set_text(name),
            c->name, places[c->place]);
    for (size_t i = 0; i < sizeof figures / sizeof *figures; ++i) {
        fprintf(file, ", \"%s\": ", figures[i].key);
        fprintf(file, isfinite(figures[i].value) ? "%.15g" : "null", figures[i].value);
    }
    fputc('}', file);
}

void duel_write_rows(FILE *file, const duel *d, const duel_title *title, bool *first) {
    for (int name = 0; name < RAY_SETS; ++name) {
        for (uint32_t i = 0; d->sets[name].count && i < d->count; ++i) {
            fputs(*first ? "\n  " : ",\n  ", file);
            write_row(file, d, title, &d->all[i], (ray_set_name)name);
            *first = false;
        }
    }
}
