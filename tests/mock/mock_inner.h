/* mock_inner.h: what the files of the mock share. One lock guards the books; functions called
 * mock_*_locked want it held. */
#ifndef MOCK_INNER_H
#define MOCK_INNER_H

#include "mock_cl.h"

#include <pthread.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* ---- Objects -------------------------------------------------------------------------------- */

/* `refs` are the caller's; `inner` those of other objects and of commands. It ends with the last of
 * both, and for the caller with the last of his. */
typedef struct mock_object {
    struct mock_object *next;
    void (*end)(struct mock_object *object); /* with the lock held */
    mock_kind kind;
    uint32_t refs, inner;
} mock_object;

struct _cl_platform_id {
    uint32_t index;
};

struct _cl_device_id {
    struct _cl_platform_id *platform;
    uint32_t index;
};

struct _cl_context {
    mock_object object;
    cl_device_id device;
};

typedef struct mock_command mock_command;

struct _cl_command_queue {
    mock_object object;
    cl_context context;
    cl_command_queue_properties properties;
    pthread_mutex_t run; /* held by who runs its commands */
    mock_command *first, *last;
};

/* The kernels of one file, for one size of stack. */
typedef void (*mock_function)(const void *scene, const void *nodes, const void *triangles,
                              const void *leaves, const void *rays, void *answers, cl_ulong first,
                              cl_ulong end);
typedef struct mock_compiled {
    const char *file;
    uint32_t stack, fp64;
    mock_function closest, any;
} mock_compiled;

extern const mock_compiled mock_compiled_kernels[]; /* written by the build; ends with file NULL */

struct _cl_program {
    mock_object object;
    cl_context context;
    char *source;
    const mock_compiled *compiled; /* NULL: not built */
    const char *log;
};

enum { MOCK_ARGUMENTS = 8, MOCK_BUFFERS = 6 };

struct _cl_kernel {
    mock_object object;
    cl_program program;
    bool any;
    uint32_t set; /* a bit for each argument */
    cl_mem buffers[MOCK_BUFFERS];
    cl_ulong first, end;
};

struct _cl_mem {
    mock_object object;
    cl_context context;
    cl_mem_flags flags;
    size_t bytes;
    char *raw, *data, *host; /* host: of CL_MEM_USE_HOST_PTR */
    uint32_t maps;
};

struct _cl_event {
    mock_object object;
    cl_command_queue queue;
    cl_int status; /* CL_QUEUED, CL_COMPLETE, or a failure */
    cl_ulong start, end;
};

/* ---- Books ---------------------------------------------------------------------------------- */

extern mock_world mock_now;

void mock_lock(void);
void mock_unlock(void);

/* Begins a call: the code that it was told to fail with, or CL_SUCCESS. */
cl_int mock_enter(const char *name, uint64_t detail);

/* Notes what no program may do, and returns `code`. */
cl_int mock_mistake(cl_int code, const char *text);
cl_int mock_mistake_locked(cl_int code, const char *text);

/* A zeroed object of `bytes` bytes, held once by the caller. */
void *mock_new(mock_kind kind, size_t bytes, void (*end)(mock_object *object));

/* Whether a handle is an object of the kind that the caller holds; any value may be asked. */
bool mock_is(const void *handle, mock_kind kind);
bool mock_is_locked(const void *handle, mock_kind kind);

cl_int mock_retain(const char *name, void *handle, mock_kind kind, cl_int invalid);
cl_int mock_release(const char *name, void *handle, mock_kind kind, cl_int invalid);

void mock_hold_locked(void *handle);
void mock_drop_locked(void *handle);

void mock_count_bytes_locked(int64_t bytes);
void mock_count_pending_locked(int change);
void mock_note_launch(size_t group);
void mock_count_shared_buffer(void);

/* Answers a clGet*Info call. */
cl_int mock_give(size_t size, void *value, size_t *size_ret, const void *data, size_t bytes);
cl_int mock_give_text(size_t size, void *value, size_t *size_ret, const char *text);

/* Ends a clCreate* call. */
void *mock_created(cl_int *code_ret, cl_int code, void *handle);

/* ---- Running -------------------------------------------------------------------------------- */

/* What a command has captured of a kernel when it was enqueued. */
typedef struct mock_launch {
    mock_function function;
    const char *file;
    bool any;
    cl_mem buffers[MOCK_BUFFERS];
    cl_ulong first, end;
    size_t items;
} mock_launch;

/* mock_run.c: runs every work-item, or remembers what it gave; with no lock held. */
void mock_run(const mock_launch *launch);

/* mock_device.c. */
bool mock_is_device(cl_device_id id);

/* ---- Commands ------------------------------------------------------------------------------- */

typedef enum mock_action { MOCK_WRITE, MOCK_READ, MOCK_MAP, MOCK_UNMAP, MOCK_LAUNCH } mock_action;

struct mock_command {
    mock_command *next;
    mock_action action;
    cl_mem buffer;
    size_t offset, bytes;
    char *host;
    mock_launch launch;
    cl_uint wait_count;
    cl_event *waits;
    cl_event event;
};

/* mock_queue.c: appends *command, whose buffers are alive, to the queue; `blocking`: and waits for
 * it. */
cl_int mock_enqueue(cl_command_queue queue, const mock_command *command, bool blocking,
                    cl_uint wait_count, const cl_event *waits, cl_event *event);

#endif
