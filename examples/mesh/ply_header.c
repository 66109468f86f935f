/* ply_header.c: the header of a PLY file, a list of elements (tables) and their properties
 * (columns). A column that the library needs gets a role; the others are only measured, to be
 * skipped. */
#include "ply_header.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { MAX_WORDS = 6 };

typedef struct word {
    const char *text;
    size_t length;
} word;

bool ply_fail(ply_reader *reader, const char *format, ...) {
    char cause[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(cause, sizeof cause, format, arguments);
    va_end(arguments);
    /* The file may hold anything, and a terminal must not be driven by it. */
    for (char *p = cause; *p; ++p)
        if (*p < ' ' || *p > '~') *p = '?';
    const bool binary = reader->line == 0;
    const unsigned long long place =
        binary ? (unsigned long long)(reader->at - reader->start) : reader->line;
    snprintf(reader->error, reader->error_size, "%s: %s %llu: %s", reader->path,
             binary ? "byte" : "line", place, cause);
    return false;
}

uint32_t ply_type_bytes(ply_type type) {
    static const uint8_t bytes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
    return bytes[type];
}

const ply_element *ply_find_element(const ply_reader *reader, const char *name) {
    for (uint32_t i = 0; i < reader->element_count; ++i)
        if (strcmp(reader->elements[i].name, name) == 0) return &reader->elements[i];
    return NULL;
}

/* ---- Words ---------------------------------------------------------------------------------- */

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

static bool word_is(word w, const char *text) {
    return w.length == strlen(text) && memcmp(w.text, text, w.length) == 0;
}

/* For messages: "%.*s" with at most 40 characters. */
#define WORD(w) (int)((w).length < 40 ? (w).length : 40), (w).text

/* Splits the next line; words past the last are dropped. False: the file ends first. */
static bool next_line(ply_reader *reader, word *words, uint32_t *count) {
    const char *at = reader->at;
    const char *line_end =
        at == reader->end ? NULL : (const char *)memchr(at, '\n', (size_t)(reader->end - at));
    ++reader->line;
    if (!line_end) return ply_fail(reader, "the header has no end_header line");
    *count = 0;
    while (*count < MAX_WORDS) {
        while (at < line_end && is_blank(*at)) ++at;
        if (at == line_end) break;
        words[*count].text = at;
        while (at < line_end && !is_blank(*at)) ++at;
        words[*count].length = (size_t)(at - words[*count].text);
        ++*count;
    }
    for (uint32_t i = *count; i < MAX_WORDS; ++i) words[i].length = 0;
    reader->at = line_end + 1;
    return true;
}

static ply_type parse_type(word w) {
    static const struct {
        const char *name, *alias;
        ply_type type;
    } names[] = {{"char", "int8", PLY_INT8},        {"uchar", "uint8", PLY_UINT8},
                 {"short", "int16", PLY_INT16},     {"ushort", "uint16", PLY_UINT16},
                 {"int", "int32", PLY_INT32},       {"uint", "uint32", PLY_UINT32},
                 {"float", "float32", PLY_FLOAT32}, {"double", "float64", PLY_FLOAT64}};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (word_is(w, names[i].name) || word_is(w, names[i].alias)) return names[i].type;
    return PLY_NO_TYPE;
}

static bool parse_count(word w, uint64_t *count) {
    *count = 0;
    for (size_t i = 0; i < w.length; ++i) {
        const char c = w.text[i];
        if (c < '0' || c > '9' || *count > (UINT64_MAX - 9) / 10) return false;
        *count = 10 * *count + (uint64_t)(c - '0');
    }
    return w.length > 0;
}

/* ---- Lines ---------------------------------------------------------------------------------- */

static bool parse_format(ply_reader *reader, const word *words) {
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (int i = 0; i < 3; ++i) {
        if (!word_is(words[1], names[i])) continue;
        reader->format = (ply_format)i;
        return word_is(words[2], "1.0") ||
               ply_fail(reader, "format version '%.*s' is not 1.0", WORD(words[2]));
    }
    return ply_fail(reader, "unknown format '%.*s'", WORD(words[1]));
}

static bool parse_element(ply_reader *reader, const word *words) {
    if (reader->element_count == PLY_MAX_ELEMENTS)
        return ply_fail(reader, "more than %d elements", PLY_MAX_ELEMENTS);
    ply_element *element = &reader->elements[reader->element_count];
    if (words[1].length == 0 || !parse_count(words[2], &element->count))
        return ply_fail(reader, "an element needs a name and a number of rows");
    snprintf(element->name, sizeof element->name, "%.*s", WORD(words[1]));
    if (ply_find_element(reader, element->name))
        return ply_fail(reader, "element '%s' appears twice", element->name);
    element->first_property = reader->property_count;
    element->property_count = 0;
    ++reader->element_count;
    return true;
}

static ply_role parse_role(const ply_element *element, word name) {
    const bool vertex = strcmp(element->name, "vertex") == 0;
    if (vertex && word_is(name, "x")) return PLY_X;
    if (vertex && word_is(name, "y")) return PLY_Y;
    if (vertex && word_is(name, "z")) return PLY_Z;
    const bool indices = word_is(name, "vertex_indices") || word_is(name, "vertex_index");
    return strcmp(element->name, "face") == 0 && indices ? PLY_INDICES : PLY_SKIPPED;
}

static bool has_role(const ply_reader *reader, ply_role role) {
    for (uint32_t i = 0; i < reader->property_count; ++i)
        if (reader->properties[i].role == role) return true;
    return false;
}

static bool parse_property(ply_reader *reader, const word *words) {
    if (reader->element_count == 0) return ply_fail(reader, "a property before any element");
    if (reader->property_count == PLY_MAX_PROPERTIES)
        return ply_fail(reader, "more than %d properties", PLY_MAX_PROPERTIES);
    ply_element *element = &reader->elements[reader->element_count - 1];
    const bool list = word_is(words[1], "list");
    const word name = words[list ? 4 : 2];
    ply_property property = {PLY_SKIPPED, parse_type(words[list ? 3 : 1]), PLY_NO_TYPE};
    if (list) property.count = parse_type(words[2]);
    if (property.type == PLY_NO_TYPE || (list && property.count == PLY_NO_TYPE))
        return ply_fail(reader, "unknown type in property '%.*s'", WORD(name));
    if (property.count >= PLY_FLOAT32)
        return ply_fail(reader, "the length of a list must be of an integer type");
    if (name.length == 0) return ply_fail(reader, "a property needs a name");

    property.role = parse_role(element, name);
    if (property.role != PLY_SKIPPED) {
        if (list != (property.role == PLY_INDICES))
            return ply_fail(reader, "'%.*s' must %sbe a list", WORD(name), list ? "not " : "");
        if (list && property.type >= PLY_FLOAT32)
            return ply_fail(reader, "vertex indices must be of an integer type");
        if (has_role(reader, property.role))
            return ply_fail(reader, "property '%.*s' appears twice", WORD(name));
    }
    reader->properties[reader->property_count++] = property;
    ++element->property_count;
    return true;
}

static bool check_header(ply_reader *reader, bool formatted) {
    if (!formatted) return ply_fail(reader, "the header has no format line");
    const ply_element *vertex = ply_find_element(reader, "vertex");
    if (!vertex) return ply_fail(reader, "the header has no element vertex");
    for (int role = PLY_X; role <= PLY_Z; ++role)
        if (!has_role(reader, (ply_role)role))
            return ply_fail(reader, "vertices have no property %c", "xyz"[role]);
    if (!has_role(reader, PLY_INDICES))
        return ply_fail(reader, "no faces with vertex_indices: is this a point cloud?");
    if (vertex->count > UINT32_MAX)
        return ply_fail(reader, "more vertices than a 32-bit index can name");
    return true;
}

bool ply_header_read(ply_reader *reader) {
    word words[MAX_WORDS];
    uint32_t count = 0;
    bool formatted = false;
    if (reader->end - reader->at < 4 || memcmp(reader->at, "ply", 3) != 0 ||
        (reader->at[3] != '\n' && reader->at[3] != '\r')) {
        reader->line = 1;
        return ply_fail(reader, "not a PLY file: it does not begin with 'ply'");
    }
    if (!next_line(reader, words, &count)) return false;
    for (;;) {
        if (!next_line(reader, words, &count)) return false;
        if (count == 0 || word_is(words[0], "comment") || word_is(words[0], "obj_info")) continue;
        if (word_is(words[0], "end_header")) return check_header(reader, formatted);
        bool ok = false;
        if (word_is(words[0], "format")) {
            ok = formatted = parse_format(reader, words);
        } else if (word_is(words[0], "element")) {
            ok = parse_element(reader, words);
        } else if (word_is(words[0], "property")) {
            ok = parse_property(reader, words);
        } else {
            ply_fail(reader, "unknown keyword '%.*s'", WORD(words[0]));
        }
        if (!ok) return false;
    }
}
