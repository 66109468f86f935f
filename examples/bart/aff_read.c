/* aff_read.c: one function per statement. A block in braces or an included file is read by the same
 * loop one level deeper, and the levels are bounded, so no text can exhaust the stack. */
#include "aff_read.h"

#include <errno.h>
#include <string.h>

enum { DEPTH_LIMIT = 64, INCLUDE_LIMIT = 16384, PATH_LIMIT = 1024 };

static bool read_statements(aff_reader *r, bool braces);

bool aff_no_memory(aff_reader *r) {
    return aff_fail(r->lexer, "out of memory");
}

/* ---- Blocks and files ----------------------------------------------------------------------- */

static bool deeper(aff_reader *r) {
    if (++r->depth <= DEPTH_LIMIT) return true;
    return aff_fail(r->lexer, "more than %d blocks and files inside each other", DEPTH_LIMIT);
}

/* `{ ... }` below a new transform. */
static bool read_block(aff_reader *r, const aff_node *node) {
    const uint32_t outer = r->node;
    if (!aff_expect(r->lexer, "{", "'{'") || !deeper(r)) return false;
    if (r->scene->nodes.count >= UINT32_MAX || !aff_node_push(&r->scene->nodes, *node))
        return aff_no_memory(r);
    r->node = (uint32_t)r->scene->nodes.count - 1;
    const bool ok = read_statements(r, true);
    r->node = outer;
    --r->depth;
    return ok;
}

static bool read_static(aff_reader *r) {
    double n[10];
    aff_node node = {r->node, AFF_NO_MOTION, affine_identity()};
    spline_key key;
    if (!aff_numbers(r->lexer, n, 10, "a number of a transform")) return false;
    spline_turn(&key, n + 3, n[6]);
    node.local = affine_from(n, key.value, n + 7);
    return read_block(r, &node);
}

static bool read_moving(aff_reader *r) {
    const aff_word name = aff_next(r->lexer);
    aff_node node = {r->node, AFF_NO_MOTION, affine_identity()};
    return aff_find_motion(r, name, &node.motion) && read_block(r, &node);
}

/* `file` beside the file that includes it. */
static bool join(aff_reader *r, aff_word file, char *out) {
    const char *slash = strrchr(r->lexer->path, '/');
    const size_t folder = slash ? (size_t)(slash + 1 - r->lexer->path) : 0;
    if (file.length == 0) return aff_fail(r->lexer, "the file ends where a file name should be");
    if (memchr(file.start, 0, file.length) || folder + file.length >= PATH_LIMIT)
        return aff_fail(r->lexer, "no such name can be included");
    memcpy(out, r->lexer->path, folder);
    memcpy(out + folder, file.start, file.length);
    out[folder + file.length] = 0;
    return true;
}

static bool includes_itself(const aff_reader *r, const char *path) {
    for (const aff_source *s = r->source; s; s = s->outer)
        if (strcmp(s->lexer.path, path) == 0) return true;
    return false;
}

bool aff_read_file(aff_reader *r, const char *path) {
    aff_source source;
    aff_lexer *outer = r->lexer;
    source.outer = r->source;
    if (!aff_open(&source.lexer, path, r->error))
        return outer ? aff_fail(outer, "%s: %s", path, strerror(errno))
                     : aff_fail(&source.lexer, "%s", strerror(errno));
    r->source = &source;
    r->lexer = &source.lexer;
    const bool ok = read_statements(r, false);
    aff_close(&source.lexer);
    r->lexer = outer;
    r->source = source.outer;
    return ok;
}

/* `i level file`: the level of detail is a wish that we always grant. */
static bool read_include(aff_reader *r) {
    double level;
    char path[PATH_LIMIT];
    if (!aff_numbers(r->lexer, &level, 1, "a level of detail")) return false;
    if (!join(r, aff_next(r->lexer), path) || !deeper(r)) return false;
    if (includes_itself(r, path)) return aff_fail(r->lexer, "%s includes itself", path);
    if (++r->includes > INCLUDE_LIMIT)
        return aff_fail(r->lexer, "more than %d included files", INCLUDE_LIMIT);
    const bool ok = aff_read_file(r, path);
    --r->depth;
    return ok;
}

/* ---- Small statements ----------------------------------------------------------------------- */

static bool read_view(aff_reader *r) {
    aff_view *v = &r->scene->view;
    for (;;) {
        double ignored[2];
        const aff_word word = aff_peek(r->lexer);
        double *vector = aff_is(word, "from") ? v->from
                         : aff_is(word, "at") ? v->at
                         : aff_is(word, "up") ? v->up
                                              : NULL;
        const bool angle = aff_is(word, "angle"), size = aff_is(word, "resolution");
        if (!vector && !angle && !size && !aff_is(word, "hither")) return true;
        aff_next(r->lexer);
        double *numbers = vector ? vector : angle ? &v->angle : ignored;
        if (!aff_numbers(r->lexer, numbers, vector ? 3 : size ? 2 : 1, "a number of the view"))
            return false;
        if (angle && !(v->angle > 0 && v->angle < 179))
            return aff_fail(r->lexer, "the angle of a view is between 0 and 179 degrees");
    }
}

/* `l [name] x y z [r g b]` */
static bool read_light(aff_reader *r) {
    double n[6] = {0, 0, 0, 1, 1, 1};
    if (!aff_is_number(aff_peek(r->lexer))) aff_next(r->lexer);
    if (!aff_numbers(r->lexer, n, 3, "a number of a light")) return false;
    if (aff_is_number(aff_peek(r->lexer)) && !aff_numbers(r->lexer, n + 3, 3, "a light's colour"))
        return false;
    const film_light light = {{n[0], n[1], n[2]}, {(float)n[3], (float)n[4], (float)n[5]}};
    return aff_light_push(&r->scene->lights, light) || aff_no_memory(r);
}

static bool read_background(aff_reader *r) {
    double n[3];
    if (!aff_numbers(r->lexer, n, 3, "a background's colour")) return false;
    for (int i = 0; i < 3; ++i) r->scene->background[i] = (float)n[i];
    return true;
}

static bool read_ambient(aff_reader *r) {
    double n[3];
    return aff_numbers(r->lexer, n, 3, "the ambient light");
}

static bool read_range(aff_reader *r) {
    double n[2];
    if (!aff_numbers(r->lexer, n, 2, "a time") ||
        !aff_whole(r->lexer, 1, 1000000, &r->scene->frames, "a number of frames"))
        return false;
    if (!(n[0] <= n[1])) return aff_fail(r->lexer, "the animation ends before it begins");
    r->scene->from = n[0];
    r->scene->to = n[1];
    return true;
}

/* `fm` ambient, diffuse, specular colour, shine, transmission, index; `f` has one colour with
 * weights. A mirror shows here as a matt surface of half its colour, and what is lit by ambient
 * light alone in that, as neither reflections nor textures are drawn. */
static bool read_material(aff_reader *r, bool full) {
    double n[12];
    film_material material;
    if (!aff_numbers(r->lexer, n, full ? 12 : 8, "a number of a material")) return false;
    for (int i = 0; i < 3; ++i) {
        const double matt = full ? n[3 + i] : n[i] * n[3];
        const double gloss = full ? n[6 + i] : n[4], glow = full ? n[i] : 0;
        const double colour = matt + 0.5 * gloss;
        material.colour[i] = (float)(colour > glow ? colour : glow);
    }
    const aff_material_list *list = &r->scene->materials;
    if (memcmp(&list->at[list->count - 1], &material, sizeof material) != 0 &&
        (list->count >= UINT32_MAX || !aff_material_push(&r->scene->materials, material)))
        return aff_no_memory(r);
    return true;
}

/* ---- Statements ----------------------------------------------------------------------------- */

static bool read_statement(aff_reader *r, aff_word word) {
    if (aff_is(word, "i")) return read_include(r);
    if (aff_is(word, "xs")) return read_static(r);
    if (aff_is(word, "x")) return read_moving(r);
    if (aff_is(word, "k")) return aff_read_keys(r);
    if (aff_is(word, "m")) return aff_read_mesh(r);
    if (aff_is(word, "p")) return aff_read_polygon(r, 3);
    if (aff_is(word, "pp")) return aff_read_polygon(r, 6);
    if (aff_is(word, "tt")) return aff_read_textured(r, 5);
    if (aff_is(word, "ttp")) return aff_read_textured(r, 8);
    if (aff_is(word, "c")) return aff_read_cone(r);
    if (aff_is(word, "tpa")) return aff_read_patch(r);
    if (aff_is(word, "fm")) return read_material(r, true);
    if (aff_is(word, "f")) return read_material(r, false);
    if (aff_is(word, "l")) return read_light(r);
    if (aff_is(word, "b")) return read_background(r);
    if (aff_is(word, "am")) return read_ambient(r);
    if (aff_is(word, "v")) return read_view(r);
    if (aff_is(word, "a")) return read_range(r);
    return aff_fail(r->lexer, "'%.*s' is no statement that is read here",
                    (int)(word.length < 32 ? word.length : 32), word.start);
}

static bool read_statements(aff_reader *r, bool braces) {
    for (;;) {
        const aff_word word = aff_next(r->lexer);
        if (word.length == 0)
            return !braces || aff_fail(r->lexer, "the file ends where '}' should be");
        if (braces && aff_is(word, "}")) return true;
        if (!read_statement(r, word)) return false;
    }
}
