/* aff_motion.c: `k name { transl n ... rot n ... scale n ... }`, and the matrices that follow. */
#include "aff_read.h"

#include <stdlib.h>
#include <string.h>

/* Names are looked up one by one; more of them than this is no scene. */
enum { MOTION_LIMIT = 4096 };

bool aff_find_motion(aff_reader *r, aff_word name, int32_t *index) {
    aff_motion_list *list = &r->scene->motions;
    if (name.length == 0 || name.length > 255 || memchr(name.start, 0, name.length))
        return aff_fail(r->lexer, "a name should follow, of at most 255 characters");
    for (size_t i = 0; i < list->count; ++i)
        if (aff_is(name, list->at[i].name)) return *index = (int32_t)i, true;
    if (list->count == MOTION_LIMIT)
        return aff_fail(r->lexer, "more than %d names", (int)MOTION_LIMIT);
    aff_motion motion;
    memset(&motion, 0, sizeof motion);
    motion.name = (char *)calloc(name.length + 1, 1);
    if (!motion.name) return aff_no_memory(r);
    memcpy(motion.name, name.start, name.length);
    if (!aff_motion_push(list, motion)) return free(motion.name), aff_no_memory(r);
    *index = (int32_t)list->count - 1;
    return true;
}

/* ---- Keys ----------------------------------------------------------------------------------- */

LIST_OF(spline_key, spline_key)

/* A time, three numbers (rot: an axis and an angle), tension, continuity, bias. */
static bool read_key(aff_reader *r, bool turn, spline_key *key) {
    double n[8];
    const uint32_t count = turn ? 8 : 7;
    if (!aff_numbers(r->lexer, n, count, "a number of a key")) return false;
    memset(key, 0, sizeof *key);
    key->time = n[0];
    if (turn)
        spline_turn(key, n + 1, n[4]);
    else
        memcpy(key->value, n + 1, 3 * sizeof *n);
    key->tension = n[count - 3];
    key->continuity = n[count - 2];
    key->bias = n[count - 1];
    return true;
}

static bool read_spline(aff_reader *r, bool turn, spline *out) {
    spline_key_list list = {NULL, 0, 0};
    uint32_t count;
    if (out->count > 0) return aff_fail(r->lexer, "a second list of the same keys");
    bool ok = aff_whole(r->lexer, 1, 1 << 24, &count, "a number of keys");
    for (uint32_t i = 0; ok && i < count; ++i) {
        spline_key key;
        ok = read_key(r, turn, &key) && (spline_key_push(&list, key) || aff_no_memory(r));
    }
    if (!ok) return free(list.at), false;
    out->keys = list.at;
    out->count = count;
    if (turn) spline_align(out);
    return true;
}

static void free_splines(aff_motion *motion) {
    free(motion->move.keys);
    free(motion->turn.keys);
    free(motion->scale.keys);
}

static bool read_splines(aff_reader *r, aff_motion *out) {
    for (;;) {
        const aff_word word = aff_next(r->lexer);
        bool ok = false;
        if (aff_is(word, "}")) return true;
        if (aff_is(word, "transl"))
            ok = read_spline(r, false, &out->move);
        else if (aff_is(word, "rot"))
            ok = read_spline(r, true, &out->turn);
        else if (aff_is(word, "scale"))
            ok = read_spline(r, false, &out->scale);
        if (!ok) return aff_fail(r->lexer, "one of transl, rot, scale or '}' should be here");
    }
}

bool aff_read_keys(aff_reader *r) {
    int32_t index;
    if (!aff_find_motion(r, aff_next(r->lexer), &index)) return false;
    aff_motion keys;
    memset(&keys, 0, sizeof keys);
    const bool ok = aff_expect(r->lexer, "{", "'{'") && read_splines(r, &keys);
    aff_motion *motion = &r->scene->motions.at[index];
    /* A part that is included twice brings its keys twice: the first ones count. */
    if (!ok || motion->given) return free_splines(&keys), ok;
    keys.name = motion->name;
    keys.given = true;
    *motion = keys;
    return true;
}

/* ---- Matrices ------------------------------------------------------------------------------- */

affine aff_motion_at(const aff_motion *motion, double time) {
    double scale[3] = {1, 1, 1}, turn[4] = {1, 0, 0, 0}, move[3] = {0, 0, 0};
    if (motion->scale.count) spline_point(&motion->scale, time, scale);
    if (motion->turn.count) spline_rotation(&motion->turn, time, turn);
    if (motion->move.count) spline_point(&motion->move, time, move);
    return affine_from(scale, turn, move);
}
