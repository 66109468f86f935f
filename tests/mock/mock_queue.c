/* mock_queue.c: queues, events, and the commands that wait in queues until someone waits for
 * them. */
#include "mock_inner.h"

static cl_ulong ticks;

/* ---- Events --------------------------------------------------------------------------------- */

static void end_event(mock_object *object) {
    mock_drop_locked(((cl_event)object)->queue);
}

static cl_event new_event(cl_command_queue queue) {
    cl_event event = (cl_event)mock_new(MOCK_EVENT, sizeof *event, end_event);
    event->queue = queue;
    event->status = CL_QUEUED;
    mock_lock();
    mock_hold_locked(queue);
    mock_unlock();
    return event;
}

static cl_int status_of(cl_event event) {
    mock_lock();
    const cl_int status = event->status;
    mock_unlock();
    return status;
}

/* ---- Running commands ----------------------------------------------------------------------- */

/* With the lock held: what the command holds, it gives back. */
static void end_command(mock_command *command) {
    mock_count_pending_locked(-1);
    mock_drop_locked(command->buffer);
    if (command->action == MOCK_LAUNCH) {
        for (int i = 0; i < MOCK_BUFFERS; ++i) mock_drop_locked(command->launch.buffers[i]);
    }
    for (cl_uint i = 0; i < command->wait_count; ++i) mock_drop_locked(command->waits[i]);
    mock_drop_locked(command->event);
    free(command->waits);
    free(command);
}

static cl_int act(mock_command *command) {
    cl_mem const buffer = command->buffer;
    switch (command->action) {
    case MOCK_WRITE:
        memcpy(buffer->data + command->offset, command->host, command->bytes);
        return CL_COMPLETE;
    case MOCK_READ:
    case MOCK_MAP:
        memcpy(command->host, buffer->data + command->offset, command->bytes);
        return CL_COMPLETE;
    case MOCK_UNMAP: return CL_COMPLETE;
    default: break;
    }
    mock_lock();
    const bool breaks = mock_now.broken_kernel && --mock_now.broken_kernel == 0;
    mock_unlock();
    if (breaks) return mock_now.broken_kernel_code;
    mock_run(&command->launch);
    return CL_COMPLETE;
}

static void drain(cl_command_queue queue);

/* Runs a command once what it waits for is done; fails with it. */
static void run(cl_command_queue queue, mock_command *command) {
    cl_int status = CL_COMPLETE;
    for (cl_uint i = 0; i < command->wait_count; ++i) {
        cl_event const wait = command->waits[i];
        if (wait->queue != queue && status_of(wait) > CL_COMPLETE) drain(wait->queue);
        if (status_of(wait) < 0) status = CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST;
    }
    if (status == CL_COMPLETE) status = act(command);
    mock_lock();
    command->event->start = ++ticks;
    command->event->end = ++ticks;
    command->event->status = status;
    end_command(command);
    mock_unlock();
}

/* Runs all that is in the queue now. Two queues that wait for each other would wait for ever. */
static void drain(cl_command_queue queue) {
    pthread_mutex_lock(&queue->run);
    for (;;) {
        mock_lock();
        mock_command *const command = queue->first;
        if (command) queue->first = command->next;
        if (!queue->first) queue->last = NULL;
        mock_unlock();
        if (!command) break;
        run(queue, command);
    }
    pthread_mutex_unlock(&queue->run);
}

/* ---- Enqueueing ----------------------------------------------------------------------------- */

static cl_int check_waits(cl_command_queue queue, cl_uint count, const cl_event *waits) {
    if ((count == 0) != (waits == NULL))
        return mock_mistake(CL_INVALID_EVENT_WAIT_LIST, "a wait list without events");
    for (cl_uint i = 0; i < count; ++i) {
        if (!mock_is(waits[i], MOCK_EVENT))
            return mock_mistake(CL_INVALID_EVENT_WAIT_LIST, "a wait list of what is no event");
        if (waits[i]->queue->context != queue->context) return CL_INVALID_CONTEXT;
    }
    return CL_SUCCESS;
}

static void hold_all(const mock_command *command) {
    mock_hold_locked(command->buffer);
    if (command->action == MOCK_LAUNCH) {
        for (int i = 0; i < MOCK_BUFFERS; ++i) mock_hold_locked(command->launch.buffers[i]);
    }
    for (cl_uint i = 0; i < command->wait_count; ++i) mock_hold_locked(command->waits[i]);
    mock_hold_locked(command->event);
}

cl_int mock_enqueue(cl_command_queue queue, const mock_command *given, bool blocking,
                    cl_uint wait_count, const cl_event *waits, cl_event *event_out) {
    const cl_int code = check_waits(queue, wait_count, waits);
    if (code) return code;
    mock_command *const command = (mock_command *)malloc(sizeof *command);
    *command = *given;
    command->next = NULL;
    command->wait_count = wait_count;
    command->waits = (cl_event *)calloc(wait_count + 1, sizeof *waits);
    for (cl_uint i = 0; i < wait_count; ++i) command->waits[i] = waits[i];
    cl_event const event = command->event = new_event(queue);
    mock_lock();
    hold_all(command);
    mock_count_pending_locked(1);
    if (queue->last) queue->last->next = command;
    if (!queue->first) queue->first = command;
    queue->last = command;
    mock_unlock();
    if (blocking) drain(queue);
    const cl_int status = status_of(event);
    if (event_out) {
        *event_out = event;
    } else {
        mock_lock();
        --event->object.refs;
        mock_hold_locked(event);
        mock_drop_locked(event);
        mock_unlock();
    }
    return status < 0 ? status : CL_SUCCESS;
}

MOCK_API cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint axes,
                                       const size_t *offset, const size_t *items,
                                       const size_t *group, cl_uint wait_count,
                                       const cl_event *waits, cl_event *event) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return refused;
    if (!mock_is(queue, MOCK_QUEUE)) return CL_INVALID_COMMAND_QUEUE;
    if (!mock_is(kernel, MOCK_KERNEL))
        return mock_mistake(CL_INVALID_KERNEL, "clEnqueueNDRangeKernel: kernel");
    if (kernel->program->context != queue->context) return CL_INVALID_CONTEXT;
    if (kernel->set != (1u << MOCK_ARGUMENTS) - 1)
        return mock_mistake(CL_INVALID_KERNEL_ARGS, "a kernel lacks arguments");
    if (axes != 1 || offset || !group || *group == 0 || *group > mock_now.group_limit ||
        *items % *group != 0)
        return mock_mistake(CL_INVALID_WORK_GROUP_SIZE, "a work-group that is too large, or odd");
    mock_command command;
    memset(&command, 0, sizeof command);
    command.action = MOCK_LAUNCH;
    command.launch.function =
        kernel->any ? kernel->program->compiled->any : kernel->program->compiled->closest;
    command.launch.file = kernel->program->compiled->file;
    command.launch.any = kernel->any;
    command.launch.first = kernel->first;
    command.launch.end = kernel->end;
    command.launch.items = *items;
    for (int i = 0; i < MOCK_BUFFERS; ++i) {
        cl_mem const buffer = kernel->buffers[i];
        if (!mock_is(buffer, MOCK_BUFFER))
            return mock_mistake(CL_INVALID_MEM_OBJECT, "a kernel's buffer is gone");
        if (buffer->context != queue->context) return CL_INVALID_CONTEXT;
        command.launch.buffers[i] = buffer;
    }
    mock_note_launch(*group);
    return mock_enqueue(queue, &command, false, wait_count, waits, event);
}

/* ---- Waiting -------------------------------------------------------------------------------- */

MOCK_API cl_int clWaitForEvents(cl_uint count, const cl_event *events) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return refused;
    if (count == 0 || !events) return mock_mistake(CL_INVALID_VALUE, "clWaitForEvents: nothing");
    bool failed = false;
    for (cl_uint i = 0; i < count; ++i) {
        if (!mock_is(events[i], MOCK_EVENT))
            return mock_mistake(CL_INVALID_EVENT, "clWaitForEvents: event");
        if (status_of(events[i]) > CL_COMPLETE) drain(events[i]->queue);
        failed = failed || status_of(events[i]) < 0;
    }
    return failed ? CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST : CL_SUCCESS;
}

MOCK_API cl_int clGetEventProfilingInfo(cl_event event, cl_profiling_info what, size_t size,
                                        void *value, size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!mock_is(event, MOCK_EVENT))
        return mock_mistake(CL_INVALID_EVENT, "clGetEventProfilingInfo: event");
    if (!(event->queue->properties & CL_QUEUE_PROFILING_ENABLE) || status_of(event) != CL_COMPLETE)
        return CL_PROFILING_INFO_NOT_AVAILABLE;
    switch (what) {
    case CL_PROFILING_COMMAND_START:
        return mock_give(size, value, size_ret, &event->start, sizeof event->start);
    case CL_PROFILING_COMMAND_END:
        return mock_give(size, value, size_ret, &event->end, sizeof event->end);
    default: return CL_INVALID_VALUE;
    }
}

MOCK_API cl_int clReleaseEvent(cl_event event) {
    return mock_release(__func__, event, MOCK_EVENT, CL_INVALID_EVENT);
}

MOCK_API cl_int clFlush(cl_command_queue queue) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return refused;
    return mock_is(queue, MOCK_QUEUE) ? CL_SUCCESS : CL_INVALID_COMMAND_QUEUE;
}

/* What is in the queue never runs. */
static void forget(cl_command_queue queue) {
    mock_lock();
    while (queue->first) {
        mock_command *const command = queue->first;
        queue->first = command->next;
        end_command(command);
    }
    queue->last = NULL;
    mock_unlock();
}

/* A queue that cannot finish is broken: its commands will not run. */
MOCK_API cl_int clFinish(cl_command_queue queue) {
    const cl_int refused = mock_enter(__func__, 0);
    if (!mock_is(queue, MOCK_QUEUE)) return CL_INVALID_COMMAND_QUEUE;
    if (refused) {
        forget(queue);
        return refused;
    }
    drain(queue);
    return CL_SUCCESS;
}

/* ---- Queues --------------------------------------------------------------------------------- */

static void end_queue(mock_object *object) {
    cl_command_queue queue = (cl_command_queue)object;
    pthread_mutex_destroy(&queue->run);
    mock_drop_locked(queue->context);
}

MOCK_API cl_command_queue clCreateCommandQueue(cl_context context, cl_device_id id,
                                               cl_command_queue_properties properties,
                                               cl_int *code) {
    const cl_int refused = mock_enter(__func__, 0);
    if (refused) return (cl_command_queue)mock_created(code, refused, NULL);
    if (!mock_is(context, MOCK_CONTEXT))
        return (cl_command_queue)mock_created(code, CL_INVALID_CONTEXT, NULL);
    if (id != context->device) return (cl_command_queue)mock_created(code, CL_INVALID_DEVICE, NULL);
    cl_command_queue queue = (cl_command_queue)mock_new(MOCK_QUEUE, sizeof *queue, end_queue);
    queue->context = context;
    queue->properties = properties;
    pthread_mutex_init(&queue->run, NULL);
    mock_lock();
    mock_hold_locked(context);
    mock_unlock();
    return (cl_command_queue)mock_created(code, CL_SUCCESS, queue);
}

MOCK_API cl_int clRetainCommandQueue(cl_command_queue queue) {
    return mock_retain(__func__, queue, MOCK_QUEUE, CL_INVALID_COMMAND_QUEUE);
}

/* What is in the queue runs still. */
MOCK_API cl_int clReleaseCommandQueue(cl_command_queue queue) {
    if (mock_is(queue, MOCK_QUEUE)) drain(queue);
    return mock_release(__func__, queue, MOCK_QUEUE, CL_INVALID_COMMAND_QUEUE);
}

MOCK_API cl_int clGetCommandQueueInfo(cl_command_queue queue, cl_command_queue_info what,
                                      size_t size, void *value, size_t *size_ret) {
    const cl_int refused = mock_enter(__func__, what);
    if (refused) return refused;
    if (!mock_is(queue, MOCK_QUEUE)) return CL_INVALID_COMMAND_QUEUE;
    switch (what) {
    case CL_QUEUE_CONTEXT:
        return mock_give(size, value, size_ret, &queue->context, sizeof queue->context);
    case CL_QUEUE_DEVICE:
        return mock_give(size, value, size_ret, &queue->context->device,
                         sizeof queue->context->device);
    case CL_QUEUE_PROPERTIES:
        return mock_give(size, value, size_ret, &queue->properties, sizeof queue->properties);
    default: return CL_INVALID_VALUE;
    }
}
