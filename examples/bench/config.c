#include "config.h"

#include "option.h"

#include <stdio.h>
#include <string.h>

/* The next word of *text, which ends at `mark`; false at the end. */
static bool next_word(const char **text, char mark, char *word, size_t size) {
    const char marks[2] = {mark, 0};
    const size_t length = strcspn(*text, marks);
    if (!**text) return false;
    snprintf(word, size, "%.*s", (int)length, *text);
    *text += length;
    *text += **text == mark;
    return true;
}

static bool add_flag(tree_config *out, const char *word) {
    static const struct {
        const char *name;
        uint32_t flag;
    } flags[] = {{"lazy", HTREE_LAZY},
                 {"morton", HTREE_MORTON},
                 {"compact", HTREE_COMPACT},
                 {"collapse", HTREE_COLLAPSE}};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; ++i) {
        if (strcmp(word, flags[i].name) != 0) continue;
        out->flags |= flags[i].flag;
        return true;
    }
    return false;
}

bool tree_config_read(const char *program, tree_config *out, const char *text) {
    char word[64] = "";
    const char *rest = text;
    memset(out, 0, sizeof *out);
    snprintf(out->name, sizeof out->name, "%.31s", text);
    next_word(&rest, '+', word, sizeof word);
    if (!option_kind(program, "kind", word, &out->kind)) return false;
    while (next_word(&rest, '+', word, sizeof word))
        if (!add_flag(out, word))
            return option_wrong(program,
                                "--kind %s: after + comes lazy, morton, compact or collapse", text);
    return true;
}

static bool add_word(peer_config *out, const char *word) {
    static const char *const qualities[] = {"low", "medium", "high", "refit"};
    if (strcmp(word, "robust") == 0) return out->robust = true;
    if (strcmp(word, "compact") == 0) return out->compact = true;
    for (int i = PEER_LOW; i <= PEER_REFIT; ++i) {
        if (strcmp(word, qualities[i]) != 0) continue;
        out->quality = (peer_quality)i;
        snprintf(out->name, sizeof out->name, "%s", word);
        return true;
    }
    return false;
}

bool peer_config_read(const char *program, peer_config *out, const char *text) {
    char word[24] = "";
    const char *rest = text;
    memset(out, 0, sizeof *out);
    out->quality = PEER_MEDIUM;
    snprintf(out->name, sizeof out->name, "medium");
    bool known = next_word(&rest, '-', word, sizeof word) && strcmp(word, "embree") == 0;
    while (known && next_word(&rest, '-', word, sizeof word)) known = add_word(out, word);
    if (!known)
        return option_wrong(
            program, "--peer %s: give embree[-low|-medium|-high|-refit][-robust][-compact]", text);
    const size_t used = strlen(out->name);
    snprintf(out->name + used, sizeof out->name - used, "%s%s", out->robust ? "-robust" : "",
             out->compact ? "-compact" : "");
    return true;
}
