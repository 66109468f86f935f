/* ply_header.h: what the header of a PLY file says, and the reader's position and error in it. */
#ifndef EXAMPLES_PLY_HEADER_H
#define EXAMPLES_PLY_HEADER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { PLY_MAX_ELEMENTS = 32, PLY_MAX_PROPERTIES = 256 };

typedef enum ply_format { PLY_ASCII, PLY_LITTLE, PLY_BIG } ply_format;

typedef enum ply_type {
    PLY_NO_TYPE,
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT32,
    PLY_FLOAT64
} ply_type;

typedef enum ply_role { PLY_X, PLY_Y, PLY_Z, PLY_INDICES, PLY_SKIPPED } ply_role;

typedef struct ply_property {
    ply_role role;
    ply_type type;  /* of the value, or of each item of a list */
    ply_type count; /* of the list's length; PLY_NO_TYPE: not a list */
} ply_property;

typedef struct ply_element {
    char name[32];
    uint64_t count;
    uint32_t first_property, property_count;
} ply_element;

typedef struct ply_reader {
    const char *path, *start, *at, *end;
    uint64_t line; /* of `at`, from 1; 0 in a binary body, whose errors name the byte */
    char *error;
    size_t error_size;

    ply_format format;
    uint32_t element_count, property_count;
    ply_element elements[PLY_MAX_ELEMENTS];
    ply_property properties[PLY_MAX_PROPERTIES];
} ply_reader;

/* Reads the header and leaves `at` on the first byte of the body. False: the error is written. */
bool ply_header_read(ply_reader *reader);

/* Writes "path: line 3: ..." or "path: byte 214: ..." and returns false. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
bool ply_fail(ply_reader *reader, const char *format, ...);

/* Bytes of one value in a binary body. */
uint32_t ply_type_bytes(ply_type type);

/* The element of that name, or NULL. */
const ply_element *ply_find_element(const ply_reader *reader, const char *name);

#endif
