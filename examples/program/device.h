/* device.h: OpenCL devices on command lines. A build without OpenCL's headers has the same calls,
 * which say what to install. */
#ifndef EXAMPLES_DEVICE_H
#define EXAMPLES_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

struct htree_cl;

/* An index, a part of the device's or the platform's name, or "default". The caller closes it with
 * device_close. NULL writes one line to `error`. */
struct htree_cl *device_open(const char *name, char *error, size_t size);
void device_close(struct htree_cl *device);

/* One line: name, platform, type, units, memory, and whether its hits have the CPU's bits. */
void device_describe(struct htree_cl *device, char *out, size_t size);

/* Whether its hits have the CPU's bits, and the seconds its compiler took so far. */
bool device_exact(struct htree_cl *device);
double device_compile_seconds(struct htree_cl *device);

/* A table of the devices there are. False writes one line to `error`. */
bool device_list(FILE *out, char *error, size_t size);

#endif
