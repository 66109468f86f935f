/* webp_file.c: libwebp's encoder of animations; it keeps the frames in memory, compressed. */
#include "webp_file.h"
#include "whole_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef HAVE_WEBP

#include <webp/encode.h>
#include <webp/mux.h>

enum { QUALITY = 80 };

struct webp_file {
    WebPAnimEncoder *encoder;
    WebPConfig config;
    uint32_t width, height;
};

webp_file *webp_open(uint32_t width, uint32_t height, char *error, size_t size) {
    WebPAnimEncoderOptions options;
    webp_file *w = (webp_file *)calloc(1, sizeof *w);
    bool ok = w && WebPAnimEncoderOptionsInit(&options) && WebPConfigInit(&w->config);
    if (ok) {
        w->width = width;
        w->height = height;
        w->config.quality = QUALITY;
        options.kmax = 30;
        w->encoder = WebPAnimEncoderNew((int)width, (int)height, &options);
        ok = w->encoder != NULL;
    }
    if (ok) return w;
    snprintf(error, size, "cannot start the animated picture: out of memory or too large");
    free(w);
    return NULL;
}

static int milliseconds(double seconds) {
    return seconds > 0 && seconds < 1e6 ? (int)(1000 * seconds + 0.5) : 0;
}

bool webp_add(webp_file *w, const picture *p, double seconds, char *error, size_t size) {
    WebPPicture frame;
    bool ok = WebPPictureInit(&frame) != 0;
    if (ok) {
        frame.width = (int)w->width;
        frame.height = (int)w->height;
        frame.use_argb = 1;
        ok = WebPPictureImportRGB(&frame, p->rgb, (int)w->width * 3) &&
             WebPAnimEncoderAdd(w->encoder, &frame, milliseconds(seconds), &w->config);
        WebPPictureFree(&frame);
    }
    if (!ok) snprintf(error, size, "webp: %s", WebPAnimEncoderGetError(w->encoder));
    return ok;
}

static bool save(const WebPData *data, const char *path, char *error, size_t size) {
    whole_file out;
    if (!whole_file_open(&out, path, error, size)) return false;
    fwrite(data->bytes, 1, data->size, out.file);
    return whole_file_close(&out, true, error, size);
}

bool webp_write(webp_file *w, double seconds, const char *path, char *error, size_t size) {
    WebPData data;
    WebPDataInit(&data);
    bool ok = WebPAnimEncoderAdd(w->encoder, NULL, milliseconds(seconds), NULL) &&
              WebPAnimEncoderAssemble(w->encoder, &data);
    if (!ok)
        snprintf(error, size, "%s: %s", path, WebPAnimEncoderGetError(w->encoder));
    else
        ok = save(&data, path, error, size);
    WebPDataClear(&data);
    return ok;
}

void webp_free(webp_file *w) {
    if (!w) return;
    WebPAnimEncoderDelete(w->encoder);
    free(w);
}

#else

webp_file *webp_open(uint32_t width, uint32_t height, char *error, size_t size) {
    (void)width, (void)height;
    snprintf(error, size,
             "this build has no libwebp: apt-get install libwebp-dev, then make again");
    return NULL;
}

bool webp_add(webp_file *w, const picture *p, double seconds, char *error, size_t size) {
    (void)w, (void)p, (void)seconds, (void)error, (void)size;
    return false;
}

bool webp_write(webp_file *w, double seconds, const char *path, char *error, size_t size) {
    (void)w, (void)seconds, (void)path, (void)error, (void)size;
    return false;
}

void webp_free(webp_file *w) {
    (void)w;
}

#endif
