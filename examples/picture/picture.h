/* picture.h: an RGB picture of 8 bits per channel, rows from the top, and its PNG file. */
#ifndef EXAMPLES_PICTURE_H
#define EXAMPLES_PICTURE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct picture {
    uint32_t width, height;
    uint8_t *rgb;
} picture;

typedef struct colour {
    float r, g, b; /* 0 to 1, as shown: gamma is applied already */
} colour;

/* Black. False: no memory; then *out is empty. */
bool picture_make(picture *out, uint32_t width, uint32_t height);
void picture_free(picture *p);

/* Pixels outside are left alone; channels are clamped. */
void picture_set(picture *p, int64_t x, int64_t y, colour c);
void picture_fill(picture *p, int64_t x, int64_t y, int64_t width, int64_t height, colour c);

/* Multiplies a rectangle by `factor`, to darken what text will be written on. */
void picture_dim(picture *p, int64_t x, int64_t y, int64_t width, int64_t height, float factor);

/* Writes `path` whole or not at all: into a file beside it, which takes its name at the end. False
 * writes one line to `error`. The bytes depend on the pixels and `title` alone. */
bool picture_write(const picture *p, const char *path, const char *title, char *error, size_t size);

/* Text in a font of 5 x 7 pixels times `scale`, from the top left corner; letters are capitals. */
void picture_text(picture *p, int64_t x, int64_t y, int scale, colour c, const char *text);

/* Width in pixels of what picture_text draws. */
int64_t picture_text_width(const char *text, int scale);

#endif
