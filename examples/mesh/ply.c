/* ply.c: the body of a PLY file, row by row. Two rules keep hostile files harmless: no count is
 * believed before the bytes that it promises are known to be there, and memory grows only by what
 * has been read. */
#include "ply.h"

#include "decimal.h"
#include "ply_header.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ply_body {
    ply_reader *reader;
    shape *out;
    uint64_t capacity; /* triangles that out->indices has room for */
    uint64_t vertex_count;
    const ply_element *element; /* that is being read, */
    uint64_t row;               /* and its row */
    const char *line_end;       /* ascii: end of the row's line */
} ply_body;

/* ---- Values --------------------------------------------------------------------------------- */

static bool fail_row(ply_body *body, const char *cause) {
    return ply_fail(body->reader, "%s in %s %llu of %llu", cause, body->element->name,
                    (unsigned long long)body->row + 1, (unsigned long long)body->element->count);
}

static void skip_blanks(ply_body *body) {
    const char *at = body->reader->at;
    while (at < body->line_end && (*at == ' ' || *at == '\t' || *at == '\r')) ++at;
    body->reader->at = at;
}

static bool read_text(ply_body *body, double *value) {
    skip_blanks(body);
    if (body->reader->at == body->line_end) return fail_row(body, "too few numbers");
    const char *end = decimal_parse(body->reader->at, body->line_end, value);
    const bool ok = end && (end == body->line_end || *end == ' ' || *end == '\t' || *end == '\r');
    if (!ok) return fail_row(body, "not a number");
    body->reader->at = end;
    return true;
}

/* Sign extension without a shift of a negative number. */
static double from_signed(uint64_t bits, uint32_t bytes) {
    const uint64_t half = UINT64_C(1) << (8 * bytes - 1);
    return (double)bits - (bits & half ? 2 * (double)half : 0);
}

static double decode(uint64_t bits, ply_type type) {
    if (type == PLY_FLOAT64) {
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    if (type == PLY_FLOAT32) {
        const uint32_t low = (uint32_t)bits;
        float value;
        memcpy(&value, &low, sizeof value);
        return (double)value;
    }
    const bool is_signed = type == PLY_INT8 || type == PLY_INT16 || type == PLY_INT32;
    return is_signed ? from_signed(bits, ply_type_bytes(type)) : (double)bits;
}

static bool read_value(ply_body *body, ply_type type, double *value) {
    ply_reader *reader = body->reader;
    if (reader->format == PLY_ASCII) return read_text(body, value);
    const uint32_t bytes = ply_type_bytes(type);
    if ((size_t)(reader->end - reader->at) < bytes) return fail_row(body, "the file ends");
    const uint8_t *p = (const uint8_t *)reader->at;
    uint64_t bits = 0;
    for (uint32_t i = 0; i < bytes; ++i)
        bits = bits << 8 | p[reader->format == PLY_BIG ? i : bytes - 1 - i];
    reader->at += bytes;
    *value = decode(bits, type);
    return true;
}

/* ---- Rows ----------------------------------------------------------------------------------- */

static bool add_triangle(ply_body *body, const uint32_t *corner) {
    shape *out = body->out;
    if (out->triangle_count == body->capacity) {
        const uint64_t capacity = body->capacity + body->capacity / 2 + 64;
        uint32_t *grown = capacity > SIZE_MAX / 12
                              ? NULL
                              : (uint32_t *)realloc(out->indices, (size_t)capacity * 12);
        if (!grown) return fail_row(body, "out of memory");
        out->indices = grown;
        body->capacity = capacity;
    }
    memcpy(out->indices + 3 * out->triangle_count++, corner, 12);
    return true;
}

/* A polygon a b c d ... becomes a b c, a c d, ...; fewer than three corners make nothing. */
static bool read_polygon(ply_body *body, ply_type type, double count) {
    uint32_t first = 0, previous = 0;
    for (double i = 0; i < count; ++i) {
        double index;
        if (!read_value(body, type, &index)) return false;
        if (!(index >= 0 && index < (double)body->vertex_count && floor(index) == index))
            return fail_row(body, "vertex index out of range");
        const uint32_t current = (uint32_t)index;
        const uint32_t corner[3] = {first, previous, current};
        if (i >= 2 && !add_triangle(body, corner)) return false;
        if (i < 1) first = current;
        previous = current;
    }
    return true;
}

static bool read_list(ply_body *body, const ply_property *property) {
    ply_reader *reader = body->reader;
    double count, ignored;
    if (!read_value(body, property->count, &count)) return false;
    if (!(count >= 0 && floor(count) == count)) return fail_row(body, "bad length of a list");
    const bool ascii = reader->format == PLY_ASCII;
    const double bytes = ascii ? 2 : ply_type_bytes(property->type);
    if (count * bytes > (double)(reader->end - reader->at) + 1)
        return fail_row(body, "the file ends before the end of a list");
    if (property->role == PLY_INDICES) return read_polygon(body, property->type, count);
    for (double i = 0; i < count; ++i)
        if (!read_value(body, property->type, &ignored)) return false;
    return true;
}

/* Doubles beyond the floats become infinite, which the library skips or refuses as it is told. */
static float to_float(double value) {
    if (value > (double)FLT_MAX) return INFINITY;
    return value < -(double)FLT_MAX ? -INFINITY : (float)value;
}

static bool begin_text_row(ply_body *body) {
    ply_reader *reader = body->reader;
    do {
        if (reader->at == reader->end) return fail_row(body, "the file ends");
        const char *line_end =
            (const char *)memchr(reader->at, '\n', (size_t)(reader->end - reader->at));
        body->line_end = line_end ? line_end : reader->end;
        ++reader->line;
        skip_blanks(body);
        if (reader->at < body->line_end) return true;
        reader->at = line_end ? line_end + 1 : reader->end;
    } while (true);
}

static bool end_text_row(ply_body *body) {
    skip_blanks(body);
    if (body->reader->at < body->line_end) return fail_row(body, "too many numbers");
    if (body->reader->at < body->reader->end) ++body->reader->at;
    return true;
}

static bool read_row(ply_body *body) {
    const bool ascii = body->reader->format == PLY_ASCII;
    const ply_property *property = body->reader->properties + body->element->first_property;
    if (ascii && !begin_text_row(body)) return false;
    for (uint32_t i = 0; i < body->element->property_count; ++i, ++property) {
        double value;
        if (property->count != PLY_NO_TYPE) {
            if (!read_list(body, property)) return false;
            continue;
        }
        if (!read_value(body, property->type, &value)) return false;
        if (property->role <= PLY_Z)
            body->out->positions[3 * body->row + (uint64_t)property->role] = to_float(value);
    }
    return !ascii || end_text_row(body);
}

/* Every row has a least size: its values in binary, a digit and a blank per value in ascii. */
static bool check_count(ply_body *body) {
    const ply_reader *reader = body->reader;
    const ply_element *element = body->element;
    const ply_property *property = reader->properties + element->first_property;
    uint64_t least = 0;
    for (uint32_t i = 0; i < element->property_count; ++i, ++property) {
        const bool list = property->count != PLY_NO_TYPE;
        least += reader->format == PLY_ASCII
                     ? 2
                     : ply_type_bytes(list ? property->count : property->type);
    }
    const uint64_t left = (uint64_t)(reader->end - reader->at) + 1;
    if (least == 0 || element->count <= left / least) return true;
    return ply_fail(body->reader, "%llu of '%s' promised, but only %llu bytes follow",
                    (unsigned long long)element->count, element->name,
                    (unsigned long long)left - 1);
}

static bool read_body(ply_reader *reader, shape *out) {
    ply_body body = {.reader = reader, .out = out};
    const ply_element *vertex = ply_find_element(reader, "vertex");
    if (reader->format != PLY_ASCII) reader->line = 0;
    for (uint32_t i = 0; i < reader->element_count; ++i) {
        body.element = &reader->elements[i];
        body.row = 0;
        if (body.element->property_count == 0) continue;
        if (!check_count(&body)) return false;
        if (body.element == vertex) {
            out->positions = (float *)malloc((size_t)(vertex->count + 1) * 12);
            if (!out->positions) return fail_row(&body, "out of memory");
        }
        body.vertex_count = vertex->count;
        for (; body.row < body.element->count; ++body.row)
            if (!read_row(&body)) return false;
    }
    out->vertex_count = vertex->count;
    return true;
}

/* ---- Files ---------------------------------------------------------------------------------- */

/* The whole file, so that every count can be held against what is left. Pipes have no size to ask
 * for, hence the growing buffer. */
static char *read_file(FILE *file, size_t *size) {
    size_t capacity = 1 << 16;
    char *data = (char *)malloc(capacity);
    *size = 0;
    while (data) {
        *size += fread(data + *size, 1, capacity - *size, file);
        if (*size < capacity) break;
        char *grown = capacity > SIZE_MAX / 2 ? NULL : (char *)realloc(data, capacity *= 2);
        if (!grown) free(data);
        data = grown;
    }
    if (data && ferror(file)) {
        const int cause = errno;
        free(data);
        data = NULL;
        errno = cause;
    }
    return data;
}

bool ply_read(const char *path, shape *out, char *error, size_t size) {
    memset(out, 0, sizeof *out);
    FILE *file = fopen(path, "rb");
    size_t bytes = 0;
    char *data = file ? read_file(file, &bytes) : NULL;
    const int cause = errno;
    if (file) fclose(file);
    if (!data) {
        snprintf(error, size, "%s: %s", path, strerror(cause));
        return false;
    }
    ply_reader *reader = (ply_reader *)calloc(1, sizeof *reader);
    if (!reader) {
        free(data);
        snprintf(error, size, "%s: out of memory", path);
        return false;
    }
    reader->path = path;
    reader->start = reader->at = data;
    reader->end = data + bytes;
    reader->error = error;
    reader->error_size = size;
    const bool ok = ply_header_read(reader) && read_body(reader, out);
    if (!ok) shape_free(out);
    free(reader);
    free(data);
    return ok;
}
