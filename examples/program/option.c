/* option.c: every value is checked before a program starts to work. */
#include "option.h"

#include "shapes.h"
#include "suggest.h"

#include <errno.h>
#include <getopt.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool option_wrong(const char *program, const char *text, ...) {
    va_list arguments;
    va_start(arguments, text);
    fprintf(stderr, "%s: ", program);
    vfprintf(stderr, text, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    return false;
}

/* strtoull alone would take signs and blanks. */
bool option_number(const char *text, char stop, uint64_t lo, uint64_t hi, uint64_t *value) {
    char *end = NULL;
    if (*text < '0' || *text > '9') return false;
    errno = 0;
    *value = strtoull(text, &end, 10);
    return errno == 0 && *end == stop && *value >= lo && *value <= hi;
}

bool option_u32(const char *program, const char *option, const char *text, uint64_t lo, uint64_t hi,
                uint32_t *value) {
    uint64_t number;
    if (!option_number(text, 0, lo, hi, &number))
        return option_wrong(program, "--%s %s: give a whole number from %llu to %llu", option, text,
                            (unsigned long long)lo, (unsigned long long)hi);
    *value = (uint32_t)number;
    return true;
}

bool option_size(const char *program, const char *text, uint32_t *width, uint32_t *height) {
    uint64_t w, h;
    const char *x = strchr(text, 'x');
    if (!x || !option_number(text, 'x', 1, 16384, &w) || !option_number(x + 1, 0, 1, 16384, &h))
        return option_wrong(
            program, "--size %s: give WIDTHxHEIGHT, each from 1 to 16384, such as 640x480", text);
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    return true;
}

bool option_shape(const char *text, char *name, uint64_t *triangles) {
    const size_t length = strcspn(text, ":");
    snprintf(name, 32, "%.*s", (int)(length < 31 ? length : 31), text);
    if (!shape_text(name)) return false;
    *triangles = shape_default_triangles(name);
    return !text[length] || option_number(text + length + 1, 0, 0, 1 << 30, triangles);
}

bool option_output(const char *program, const char *option, const char *text, const char **path) {
    char folder[1024] = ".";
    const char *slash = strrchr(text, '/');
    if (slash) snprintf(folder, sizeof folder, "%.*s", (int)(slash - text) + 1, text);
    *path = text;
    if (access(folder, W_OK) == 0) return true;
    return option_wrong(program, "--%s %s: %s: %s; name a file in a folder that can be written to",
                        option, text, folder, strerror(errno));
}

/* Appends a blank and a word, as far as there is room. */
static void append(char *list, size_t size, const char *word) {
    const size_t used = strlen(list);
    snprintf(list + used, size - used, " %s", word);
}

bool option_scene(const char *program, const char *text, char *name, uint64_t *triangles) {
    char known[256] = "";
    if (option_shape(text, name, triangles)) return true;
    if (shape_text(name))
        return option_wrong(program, "--scene %s: after ':' give a number of triangles up to 2^30",
                            text);
    for (const char *const *word = shape_names(); *word; ++word) append(known, sizeof known, *word);
    return option_wrong(program, "--scene %s: no such scene; choose from%s", text, known);
}

bool option_kind(const char *program, const char *option, const char *text, htree_kind *kind) {
    char known[256] = "";
    *kind = htree_kind_from_name(text);
    if (*kind) return true;
    for (htree_kind i = 1; htree_kind_name(i); ++i) append(known, sizeof known, htree_kind_name(i));
    for (htree_kind i = HTREE_FAST; htree_kind_name(i); ++i)
        append(known, sizeof known, htree_kind_name(i));
    return option_wrong(program, "--%s %s: no such structure; choose from%s", option, text, known);
}

bool option_kind_add(const char *program, const char *option, const char *text, htree_kind *kinds,
                     uint32_t *count, uint32_t most) {
    htree_kind kind;
    if (!option_kind(program, option, text, &kind)) return false;
    for (uint32_t i = 0; i < *count; ++i)
        if (kinds[i] == kind) return true;
    if (*count == most) return option_wrong(program, "more than %u structures", most);
    kinds[(*count)++] = kind;
    return true;
}

bool option_list(const char *program, const char *option, const char *text,
                 bool (*take)(void *user, const char *name), void *user) {
    char word[64];
    for (;;) {
        const size_t length = strcspn(text, ",");
        if (!length || length >= sizeof word)
            return option_wrong(program, "--%s: a list of names with commas between them", option);
        snprintf(word, sizeof word, "%.*s", (int)length, text);
        if (!take(user, word)) return false;
        if (!text[length]) return true;
        text += length + 1;
    }
}

/* getopt names a short option by its letter, and leaves a long one at the word before optind. */
static void complain(const option_syntax *syntax, int answer, char **argv) {
    const char letter[3] = {'-', (char)optopt, 0}, *meant = NULL;
    const bool is_short = optopt > 0 && optopt < 256 && argv[optind - 1][1] != '-';
    const char *word = is_short ? letter : argv[optind - 1];
    char name[32] = "";
    if (answer == ':') {
        option_wrong(syntax->program, "option %s needs a value; see --help", word);
        return;
    }
    if (!is_short) snprintf(name, sizeof name, "%.*s", (int)strcspn(word + 2, "="), word + 2);
    for (const struct option *option = syntax->options; *name && option->name; ++option)
        meant = suggest(name, meant, option->name);
    option_wrong(syntax->program,
                 meant ? "unknown option %s; did you mean --%s?" : "unknown option %s; see --help",
                 word, meant);
}

uint32_t option_threads(uint32_t threads) {
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    return threads ? threads : cores > 0 ? (uint32_t)cores : 1;
}

int option_next(const option_syntax *syntax, int argc, char **argv, args_result *result) {
    opterr = 0;
    const int option = getopt_long(argc, argv, syntax->letters, syntax->options, NULL);
    *result = option == -1 ? ARGS_RUN : ARGS_DONE;
    switch (option) {
    case 'h': fputs(syntax->help, stdout); return -1;
    case 'V':
        printf("%s %d.%d.%d\n", syntax->program, HTREE_VERSION_MAJOR, HTREE_VERSION_MINOR,
               HTREE_VERSION_PATCH);
        return -1;
    case ':':
    case '?':
        complain(syntax, option, argv);
        *result = ARGS_WRONG;
        return -1;
    default: return option;
    }
}

bool option_one_mesh(const char *program, int argc, char **argv, bool scene, const char **path) {
    if (optind < argc) *path = argv[optind];
    if (argc - optind > 1) {
        return option_wrong(program, "one mesh at a time, not '%s' too", argv[optind + 1]);
    }
    return !*path || !scene || option_wrong(program, "give a mesh or --scene, not both");
}
