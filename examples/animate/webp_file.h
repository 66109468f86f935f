/* webp_file.h: an animated picture. Needs libwebp; without it opening fails and says so. */
#ifndef EXAMPLES_WEBP_FILE_H
#define EXAMPLES_WEBP_FILE_H

#include "picture.h"

typedef struct webp_file webp_file;

/* NULL: one line is in `error`. */
webp_file *webp_open(uint32_t width, uint32_t height, char *error, size_t size);

/* Adds a frame that is shown from `seconds` on. */
bool webp_add(webp_file *w, const picture *p, double seconds, char *error, size_t size);

/* Writes the file whole, by way of one beside it; the last frame is shown until `seconds`. */
bool webp_write(webp_file *w, double seconds, const char *path, char *error, size_t size);

/* NULL is allowed. */
void webp_free(webp_file *w);

#endif
