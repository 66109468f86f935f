/* whole_file.c: a file beside the one that is wanted, and its new name. */
#include "whole_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool whole_file_open(whole_file *out, const char *path, char *error, size_t size) {
    struct stat status;
    const size_t length = strlen(path) + sizeof ".part";
    out->path = path;
    out->file = NULL;
    out->is_device = stat(path, &status) == 0 && !S_ISREG(status.st_mode);
    out->part = (char *)malloc(length);
    if (out->part) {
        snprintf(out->part, length, "%s%s", path, out->is_device ? "" : ".part");
        out->file = fopen(out->part, "wb");
    }
    if (out->file) return true;
    snprintf(error, size, "%s: %s", path, strerror(errno));
    free(out->part);
    return false;
}

bool whole_file_close(whole_file *out, bool good, char *error, size_t size) {
    const bool written = !ferror(out->file);
    int cause = errno;
    bool whole = fclose(out->file) == 0;
    if (whole && written && good && !out->is_device) whole = rename(out->part, out->path) == 0;
    if (written && !whole) cause = errno;
    whole = whole && written && good;
    if (!whole && !out->is_device) remove(out->part);
    if (!whole && (good || !written)) snprintf(error, size, "%s: %s", out->path, strerror(cause));
    free(out->part);
    return whole;
}
