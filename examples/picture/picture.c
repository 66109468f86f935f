/* picture.c: pixels, and PNG by libpng's row interface. */
#include "picture.h"
#include "whole_file.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool picture_make(picture *out, uint32_t width, uint32_t height) {
    out->width = width;
    out->height = height;
    out->rgb = (uint8_t *)calloc((size_t)width * height, 3);
    return out->rgb != NULL;
}

void picture_free(picture *p) {
    free(p->rgb);
    memset(p, 0, sizeof *p);
}

/* NaN becomes 0: the comparison is false for it. */
static uint8_t to_byte(float x) {
    return (uint8_t)(x > 0 ? x < 1 ? (int)(x * 255 + 0.5f) : 255 : 0);
}

void picture_set(picture *p, int64_t x, int64_t y, colour c) {
    if (x < 0 || y < 0 || x >= (int64_t)p->width || y >= (int64_t)p->height) return;
    uint8_t *rgb = p->rgb + 3 * ((size_t)y * p->width + (size_t)x);
    rgb[0] = to_byte(c.r);
    rgb[1] = to_byte(c.g);
    rgb[2] = to_byte(c.b);
}

void picture_fill(picture *p, int64_t x, int64_t y, int64_t width, int64_t height, colour c) {
    for (int64_t j = 0; j < height; ++j)
        for (int64_t i = 0; i < width; ++i) picture_set(p, x + i, y + j, c);
}

void picture_dim(picture *p, int64_t x, int64_t y, int64_t width, int64_t height, float factor) {
    for (int64_t j = y < 0 ? 0 : y; j < y + height && j < (int64_t)p->height; ++j) {
        for (int64_t i = x < 0 ? 0 : x; i < x + width && i < (int64_t)p->width; ++i) {
            uint8_t *rgb = p->rgb + 3 * ((size_t)j * p->width + (size_t)i);
            for (int k = 0; k < 3; ++k) rgb[k] = (uint8_t)((float)rgb[k] * factor);
        }
    }
}

/* ---- PNG ---------------------------------------------------------------------------------------
 */

typedef struct write_failure {
    jmp_buf back;
    char text[160];
} write_failure;

static void on_error(png_structp png, png_const_charp text) {
    write_failure *error = (write_failure *)png_get_error_ptr(png);
    snprintf(error->text, sizeof error->text, "%s", text);
    longjmp(error->back, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png, (void)text;
}

static void write_chunks(png_structp png, png_infop info, const picture *p, const char *title) {
    char software_key[] = "Software", software[] = "htree-render", title_key[] = "Title";
    char title_text[160];
    snprintf(title_text, sizeof title_text, "%s", title);
    png_text text[2];
    memset(text, 0, sizeof text);
    for (int i = 0; i < 2; ++i) text[i].compression = PNG_TEXT_COMPRESSION_NONE;
    text[0].key = software_key;
    text[0].text = software;
    text[1].key = title_key;
    text[1].text = title_text;
    png_set_IHDR(png, info, p->width, p->height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_text(png, info, text, 2);
    png_write_info(png, info);
    for (uint32_t y = 0; y < p->height; ++y) png_write_row(png, p->rgb + (size_t)y * p->width * 3);
    png_write_end(png, info);
}

/* libpng leaves by longjmp on any error. png and info are set before setjmp and not changed after
 * it, so they keep their values without being volatile. */
static bool write_png(FILE *file, const picture *p, const char *title, write_failure *error) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, error, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    snprintf(error->text, sizeof error->text, "out of memory");
    if (!info || setjmp(error->back)) {
        png_destroy_write_struct(&png, &info);
        return false;
    }
    png_init_io(png, file);
    write_chunks(png, info, p, title);
    png_destroy_write_struct(&png, &info);
    return true;
}

bool picture_write(const picture *p, const char *path, const char *title, char *error,
                   size_t size) {
    whole_file out;
    write_failure png;
    if (!whole_file_open(&out, path, error, size)) return false;
    const bool ok = write_png(out.file, p, title, &png);
    if (!ok) snprintf(error, size, "%s: %s", path, png.text);
    return whole_file_close(&out, ok, error, size);
}
