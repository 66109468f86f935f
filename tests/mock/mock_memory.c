/* mock_memory.c: buffers: exact to the byte, and a copy of their own even over the host's
 * memory. */
#include "mock_inner.h"

enum { ALIGNMENT = 128 };

static void end_buffer(mock_object *object) {
    cl_mem buffer = (cl_mem)object;
    if (buffer->maps)
        (void)mock_mistake_locked(CL_SUCCESS, "a buffer was released while it was mapped");
    mock_count_bytes_locked(-(int64_t)buffer->bytes);
    free(buffer->raw);
    mock_drop_locked(buffer->context);
}

/* Ends where the buffer ends, for ASan to see; over the host's memory it is aligned as that is. */
static void make_room(cl_mem buffer) {
    const size_t shift = (uintptr_t)buffer->host % ALIGNMENT;
    void *raw = NULL;
    if (posix_memalign(&raw, ALIGNMENT, shift + buffer->bytes) != 0) abort();
    memset(raw, 0xa5, shift + buffer->bytes);
    buffer->raw = (char *)raw;
    buffer->data = buffer->raw + shift;
}

static cl_int check_flags(cl_mem_flags flags, const void *host) {
    const bool wants_host = flags & (CL_MEM_USE_HOST_PTR | CL_MEM_COPY_HOST_PTR);
    if (wants_host != (host != NULL))
        return mock_mistake(CL_INVALID_HOST_PTR, "clCreateBuffer: host pointer");
    if ((flags & CL_MEM_USE_HOST_PTR) && (flags & CL_MEM_COPY_HOST_PTR))
        return mock_mistake(CL_INVALID_VALUE, "clCreateBuffer: flags");
    return CL_SUCCESS;
}

MOCK_API cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void *host,
                               cl_int *code) {
    cl_int refused = mock_enter(__func__, flags);
    if (refused) return (cl_mem)mock_created(code, refused, NULL);
    if (!mock_is(context, MOCK_CONTEXT))
        return (cl_mem)mock_created(code, CL_INVALID_CONTEXT, NULL);
    refused = check_flags(flags, host);
    if (!refused && (bytes == 0 || bytes > mock_now.buffer_bytes))
        refused = mock_mistake(CL_INVALID_BUFFER_SIZE, "clCreateBuffer: size");
    if (!refused && mock_live_bytes() + bytes > mock_now.memory_bytes)
        refused = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    if (refused) return (cl_mem)mock_created(code, refused, NULL);
    cl_mem buffer = (cl_mem)mock_new(MOCK_BUFFER, sizeof *buffer, end_buffer);
    buffer->context = context;
    buffer->flags = flags;
    buffer->bytes = bytes;
    if (flags & CL_MEM_USE_HOST_PTR) buffer->host = (char *)host;
    make_room(buffer);
    if (host) memcpy(buffer->data, host, bytes);
    if (buffer->host) mock_count_shared_buffer();
    mock_lock();
    mock_hold_locked(context);
    mock_count_bytes_locked((int64_t)bytes);
    mock_unlock();
    return (cl_mem)mock_created(code, CL_SUCCESS, buffer);
}

MOCK_API cl_int clReleaseMemObject(cl_mem buffer) {
    return mock_release(__func__, buffer, MOCK_BUFFER, CL_INVALID_MEM_OBJECT);
}

MOCK_API cl_int clGetMemObjectInfo(cl_mem buffer, cl_mem_info what, size_t size, void *value,
                                   size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!mock_is(buffer, MOCK_BUFFER)) return CL_INVALID_MEM_OBJECT;
    switch (what) {
    case CL_MEM_SIZE: return mock_give(size, value, size_ret, &buffer->bytes, sizeof buffer->bytes);
    case CL_MEM_FLAGS:
        return mock_give(size, value, size_ret, &buffer->flags, sizeof buffer->flags);
    case CL_MEM_CONTEXT:
        return mock_give(size, value, size_ret, &buffer->context, sizeof buffer->context);
    default: return CL_INVALID_VALUE;
    }
}

/* ---- Transfers ------------------------------------------------------------------------------ */

/* Writes the command to *out. */
static cl_int transfer(cl_command_queue queue, mock_action action, cl_mem buffer, size_t offset,
                       size_t bytes, const void *host, mock_command *out) {
    memset(out, 0, sizeof *out);
    if (!mock_is(queue, MOCK_QUEUE)) return CL_INVALID_COMMAND_QUEUE;
    if (!mock_is(buffer, MOCK_BUFFER))
        return mock_mistake(CL_INVALID_MEM_OBJECT, "a transfer of what is no buffer");
    if (buffer->context != queue->context) return CL_INVALID_CONTEXT;
    if (!host || bytes == 0 || offset > buffer->bytes || bytes > buffer->bytes - offset)
        return mock_mistake(CL_INVALID_VALUE, "a transfer beyond a buffer");
    out->action = action;
    out->buffer = buffer;
    out->offset = offset;
    out->bytes = bytes;
    out->host = (char *)(uintptr_t)host;
    return CL_SUCCESS;
}

MOCK_API cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                     size_t offset, size_t bytes, const void *host,
                                     cl_uint wait_count, const cl_event *waits, cl_event *event) {
    mock_command command;
    cl_int code = mock_enter(__func__, 0);
    if (!code) code = transfer(queue, MOCK_WRITE, buffer, offset, bytes, host, &command);
    return code ? code
                : mock_enqueue(queue, &command, blocking != CL_FALSE, wait_count, waits, event);
}

MOCK_API cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                    size_t offset, size_t bytes, void *host, cl_uint wait_count,
                                    const cl_event *waits, cl_event *event) {
    mock_command command;
    cl_int code = mock_enter(__func__, 0);
    if (!code) code = transfer(queue, MOCK_READ, buffer, offset, bytes, host, &command);
    return code ? code
                : mock_enqueue(queue, &command, blocking != CL_FALSE, wait_count, waits, event);
}

/* Only for reading, and only of buffers over the host's memory: no one asks for more. */
MOCK_API void *clEnqueueMapBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking,
                                  cl_map_flags flags, size_t offset, size_t bytes,
                                  cl_uint wait_count, const cl_event *waits, cl_event *event,
                                  cl_int *code) {
    mock_command command;
    cl_int refused = mock_enter(__func__, 0);
    if (refused) return mock_created(code, refused, NULL);
    char *const host = mock_is(buffer, MOCK_BUFFER) ? buffer->host : NULL;
    refused =
        transfer(queue, MOCK_MAP, buffer, offset, bytes, host ? host + offset : NULL, &command);
    if (!refused && flags != CL_MAP_READ)
        refused = mock_mistake(CL_INVALID_VALUE, "clEnqueueMapBuffer: flags");
    if (!refused)
        refused = mock_enqueue(queue, &command, blocking != CL_FALSE, wait_count, waits, event);
    if (refused) return mock_created(code, refused, NULL);
    mock_lock();
    ++buffer->maps;
    mock_unlock();
    return mock_created(code, CL_SUCCESS, command.host);
}

MOCK_API cl_int clEnqueueUnmapMemObject(cl_command_queue queue, cl_mem buffer, void *mapped,
                                        cl_uint wait_count, const cl_event *waits,
                                        cl_event *event) {
    mock_command command;
    cl_int code = mock_enter(__func__, 0);
    const cl_int refused = code;
    if (!code) code = transfer(queue, MOCK_UNMAP, buffer, 0, 1, mapped, &command);
    if (code && !refused) return code;
    mock_lock();
    const bool is_mapped = buffer->maps > 0 && mapped == buffer->host;
    if (is_mapped) --buffer->maps;
    mock_unlock();
    if (!is_mapped) return mock_mistake(CL_INVALID_VALUE, "unmapped what was not mapped");
    if (refused) return refused; /* whoever asked has done his part */
    return mock_enqueue(queue, &command, false, wait_count, waits, event);
}
