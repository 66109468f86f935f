/* heat.c: colour maps for counts. The legend says what the colours mean in numbers, and is left out
 * rather than squeezed when the picture is too small for it. */
#include "heat.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

colour heat_colour(double x) {
    /* Points along a path through CIE L*a*b* whose lightness rises by 11 from each to the next. */
    static const colour points[9] = {{.02f, .05f, .20f}, {.20f, .09f, .42f}, {.45f, .07f, .50f},
                                     {.69f, .12f, .47f}, {.88f, .23f, .38f}, {.97f, .42f, .30f},
                                     {.99f, .63f, .33f}, {.99f, .82f, .50f}, {1.0f, .97f, .80f}};
    const double place = x > 0 ? (x < 1 ? 8 * x : 8) : 0;
    const int i = place < 7 ? (int)place : 7;
    const float f = (float)(place - i);
    const colour a = points[i], b = points[i + 1];
    const colour c = {a.r + f * (b.r - a.r), a.g + f * (b.g - a.g), a.b + f * (b.b - a.b)};
    return c;
}

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool heat_measure(heat_scale *out, const char *title, bool whole, const float *values,
                  uint64_t count, double fixed) {
    float *sorted = (float *)malloc((size_t)(count + 1) * sizeof *sorted);
    if (!sorted) return false;
    uint64_t known = 0;
    double sum = 0;
    for (uint64_t i = 0; i < count; ++i) {
        if (isnan(values[i])) continue;
        sorted[known++] = values[i];
        sum += (double)values[i];
    }
    qsort(sorted, (size_t)known, sizeof *sorted, compare_floats);
    memset(out, 0, sizeof *out);
    out->title = title;
    out->whole = whole;
    if (known) {
        out->lo = whole ? 0 : (double)sorted[0];
        out->max = (double)sorted[known - 1];
        out->hi = whole ? (double)sorted[known - 1 - known / 200] : out->max;
        out->mean = sum / (double)known;
    }
    if (fixed > 0) out->hi = fixed;
    if (!(out->hi > out->lo)) out->hi = out->lo + 1;
    free(sorted);
    return true;
}

static void format_number(char *text, size_t size, double value, bool whole) {
    snprintf(text, size, whole ? "%.0f" : "%.4g", value);
}

static void draw_legend(picture *p, const heat_scale *scale) {
    static const colour ink = {1, 1, 1};
    char low[32], high[40], most[32], note[128], number[32];
    const int zoom = p->width >= 900 && p->height >= 600 ? 2 : 1;
    const int64_t margin = 8 * zoom, bar = 8 * zoom, text = 7 * zoom;
    const int64_t height = 2 * text + bar + 4 * margin - 6 * zoom, width = (int64_t)p->width;
    const int64_t top = (int64_t)p->height - height;
    format_number(low, sizeof low, scale->lo, scale->whole);
    format_number(number, sizeof number, scale->hi, scale->whole);
    format_number(most, sizeof most, scale->max, scale->whole);
    snprintf(high, sizeof high, "%s%s", scale->max > scale->hi ? ">=" : "", number);
    snprintf(note, sizeof note, "mean %.4g  max %s", scale->mean, most);
    const int64_t title_width = picture_text_width(scale->title, zoom);
    const int64_t note_width = picture_text_width(note, zoom);
    if (width < title_width + 3 * margin || top < height) return;

    picture_dim(p, 0, top, width, height, 0.35f);
    int64_t y = top + margin;
    picture_text(p, margin, y, zoom, ink, scale->title);
    if (width >= title_width + note_width + 4 * margin)
        picture_text(p, width - margin - note_width, y, zoom, ink, note);
    y += text + margin - 3 * zoom;
    const int64_t length = width - 2 * margin;
    for (int64_t i = 0; i < length; ++i)
        picture_fill(p, margin + i, y, 1, bar, heat_colour(((double)i + 0.5) / (double)length));
    y += bar + margin - 3 * zoom;
    picture_text(p, margin, y, zoom, ink, low);
    picture_text(p, width - margin - picture_text_width(high, zoom), y, zoom, ink, high);
}

void heat_paint(picture *p, const heat_scale *scale, const float *values) {
    static const colour grey = {.16f, .17f, .19f};
    for (int64_t y = 0; y < (int64_t)p->height; ++y) {
        for (int64_t x = 0; x < (int64_t)p->width; ++x) {
            const double value = (double)*values++;
            const double place = (value - scale->lo) / (scale->hi - scale->lo);
            picture_set(p, x, y, isnan(value) ? grey : heat_colour(place));
        }
    }
    draw_legend(p, scale);
}
