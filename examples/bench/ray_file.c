/* ray_file.c: rays to a file and back, bit for bit. */
#include "ray_sets.h"
#include "whole_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE = 256 };
static const uint64_t most_rays = UINT64_C(1) << 32;

static bool fail(char *error, size_t size, const char *path, const char *why) {
    snprintf(error, size, "%s: %s", path, why);
    return false;
}

/* The first line; floats are in the order of the machine that wrote them. */
static const char *head(void) {
    const uint32_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first ? "htree-rays 1 little-endian\n" : "htree-rays 1 big-endian\n";
}

/* ---- Saving --------------------------------------------------------------------------------- */

bool ray_sets_save(const ray_set *sets, uint64_t triangles, const char *path, char *error,
                   size_t size) {
    whole_file out;
    if (!whole_file_open(&out, path, error, size)) return false;
    fprintf(out.file, "%striangles %llu\n", head(), (unsigned long long)triangles);
    for (int i = 0; i < RAY_SETS; ++i)
        fprintf(out.file, "%s %llu %u %s\n", ray_set_text((ray_set_name)i),
                (unsigned long long)sets[i].count, sets[i].row, sets[i].note);
    fputs("end\n", out.file);
    for (int i = 0; i < RAY_SETS; ++i)
        fwrite(sets[i].rays, sizeof *sets[i].rays, (size_t)sets[i].count, out.file);
    return whole_file_close(&out, true, error, size);
}

/* ---- Loading -------------------------------------------------------------------------------- */

static bool read_line(FILE *file, char *line) {
    return fgets(line, LINE, file) && strchr(line, '\n');
}

/* "NAME COUNT ROW NOTE" */
static bool read_set(FILE *file, ray_set *set, ray_set_name name) {
    char line[LINE], word[16];
    unsigned long long count;
    int used = 0;
    if (!read_line(file, line) ||
        sscanf(line, "%15s %llu %u %n", word, &count, &set->row, &used) != 3 || !used)
        return false;
    line[strcspn(line, "\n")] = 0;
    snprintf(set->note, sizeof set->note, "%.*s", (int)sizeof set->note - 1, line + used);
    set->count = count;
    const bool picture = name == RAYS_PRIMARY || name == RAYS_FRAME;
    return count <= most_rays && picture == (set->row > 0) && strcmp(word, ray_set_text(name)) == 0;
}

static bool read_head(FILE *file, ray_set *sets, uint64_t *triangles) {
    char line[LINE];
    unsigned long long number = 0;
    if (!read_line(file, line) || strcmp(line, head()) != 0) return false;
    if (!read_line(file, line) || sscanf(line, "triangles %llu", &number) != 1) return false;
    *triangles = number;
    for (int i = 0; i < RAY_SETS; ++i)
        if (!read_set(file, &sets[i], (ray_set_name)i)) return false;
    return read_line(file, line) && strcmp(line, "end\n") == 0;
}

/* NULL, or what is wrong. Memory is taken as rays come, for a count may be a lie. */
static const char *read_rays(FILE *file, ray_set *set) {
    uint64_t have = 0, room = 0;
    while (have < set->count) {
        if (have == room) {
            room = room ? 2 * room : 65536;
            if (room > set->count) room = set->count;
            void *more = realloc(set->rays, (size_t)room * sizeof *set->rays);
            if (!more) return "out of memory";
            set->rays = (htree_ray *)more;
        }
        const size_t part = fread(set->rays + have, sizeof *set->rays, (size_t)(room - have), file);
        if (!part) return "ends before the last ray";
        have += part;
    }
    return NULL;
}

static const char *read_file(FILE *file, ray_set *sets, uint64_t triangles) {
    uint64_t of = 0;
    if (!read_head(file, sets, &of)) return "not a file of rays that --save-rays wrote here";
    if (of != triangles) return "rays of a scene with another number of triangles";
    if (!sets[RAYS_PRIMARY].count || !sets[RAYS_FRAME].count) return "no primary rays in it";
    for (int i = 0; i < RAY_SETS; ++i) {
        const char *why = read_rays(file, &sets[i]);
        if (why) return why;
    }
    return fgetc(file) == EOF ? NULL : "more in it than rays";
}

bool ray_sets_load(ray_set *sets, uint64_t triangles, const char *path, char *error, size_t size) {
    memset(sets, 0, RAY_SETS * sizeof *sets);
    FILE *file = fopen(path, "rb");
    if (!file) return fail(error, size, path, strerror(errno));
    const char *why = read_file(file, sets, triangles);
    fclose(file);
    if (!why) return true;
    ray_sets_free(sets);
    return fail(error, size, path, why);
}
