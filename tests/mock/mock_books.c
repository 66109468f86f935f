/* mock_books.c: the books of the mock: objects, calls, mistakes. */
#include "mock_inner.h"

/* Ends of objects are kept for a while, so that no new object has the address of one that was just
 * released, and its second release is seen. */
enum { ASHES = 512 };

mock_world mock_now;

static pthread_mutex_t books = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t all_met = PTHREAD_COND_INITIALIZER;
static uint32_t meeting;
static mock_object *objects;
static mock_object *ashes[ASHES];
static uint64_t ash_count, calls, fail_at, mistakes, shared_buffers;
static int64_t live_bytes, pending;
static size_t last_group;
static bool fail_for_good;
static cl_int fail_code;
static const char *first_mistake = "";

enum { TRACED = 4096 };
static struct {
    const char *name;
    uint64_t detail;
} trace[TRACED];

void mock_lock(void) {
    pthread_mutex_lock(&books);
}

void mock_unlock(void) {
    pthread_mutex_unlock(&books);
}

/* ---- World ---------------------------------------------------------------------------------- */

mock_world mock_usual_world(void) {
    mock_world world;
    memset(&world, 0, sizeof world);
    world.platforms = world.devices = 1;
    world.type = CL_DEVICE_TYPE_CPU;
    world.available = world.unified = world.fp64 = world.denormals = true;
    world.memory_bytes = (cl_ulong)1 << 32;
    world.buffer_bytes = (cl_ulong)1 << 30;
    world.group_limit = 4096;
    return world;
}

void mock_set_world(const mock_world *world) {
    mock_lock();
    mock_now = *world;
    mock_unlock();
}

/* A program that was not told anything, as one that finds the mock by its name, has the usual
 * world. */
__attribute__((constructor)) static void begin(void) {
    mock_now = mock_usual_world();
}

/* ---- Calls ---------------------------------------------------------------------------------- */

void mock_fail(uint64_t call, cl_int code, bool for_good) {
    mock_lock();
    calls = 0;
    fail_at = call;
    fail_code = code;
    fail_for_good = for_good;
    mock_unlock();
}

cl_int mock_enter(const char *name, uint64_t detail) {
    mock_lock();
    if (calls < TRACED) {
        trace[calls].name = name;
        trace[calls].detail = detail;
    }
    ++calls;
    const bool fails = fail_at && (calls == fail_at || (fail_for_good && calls > fail_at));
    mock_unlock();
    return fails ? fail_code : CL_SUCCESS;
}

uint64_t mock_calls(void) {
    mock_lock();
    const uint64_t count = calls;
    mock_unlock();
    return count;
}

const char *mock_call(uint64_t call, uint64_t *detail) {
    const bool known = call >= 1 && call <= calls && call <= TRACED;
    if (detail) *detail = known ? trace[call - 1].detail : 0;
    return known ? trace[call - 1].name : "";
}

uint64_t mock_pending(void) {
    mock_lock();
    const int64_t count = pending;
    mock_unlock();
    return (uint64_t)count;
}

cl_int mock_mistake_locked(cl_int code, const char *text) {
    if (mistakes++ == 0) first_mistake = text;
    return code;
}

cl_int mock_mistake(cl_int code, const char *text) {
    mock_lock();
    (void)mock_mistake_locked(code, text);
    mock_unlock();
    return code;
}

uint64_t mock_mistakes(void) {
    mock_lock();
    const uint64_t count = mistakes;
    mock_unlock();
    return count;
}

const char *mock_first_mistake(void) {
    return first_mistake;
}

/* ---- Objects -------------------------------------------------------------------------------- */

void *mock_new(mock_kind kind, size_t bytes, void (*end)(mock_object *object)) {
    mock_object *const object = (mock_object *)calloc(1, bytes);
    if (!object) abort();
    object->kind = kind;
    object->end = end;
    object->refs = 1;
    mock_lock();
    object->next = objects;
    objects = object;
    mock_unlock();
    return object;
}

bool mock_is_locked(const void *handle, mock_kind kind) {
    for (const mock_object *o = objects; o; o = o->next) {
        if (o == handle) return o->kind == kind && o->refs > 0;
    }
    return false;
}

bool mock_is(const void *handle, mock_kind kind) {
    mock_lock();
    const bool is = mock_is_locked(handle, kind);
    mock_unlock();
    return is;
}

static void end_if_unheld(mock_object *object) {
    if (object->refs || object->inner) return;
    mock_object **place = &objects;
    while (*place != object) place = &(*place)->next;
    *place = object->next;
    if (object->end) object->end(object);
    free(ashes[ash_count % ASHES]);
    ashes[ash_count++ % ASHES] = object;
}

void mock_hold_locked(void *handle) {
    if (handle) ++((mock_object *)handle)->inner;
}

void mock_drop_locked(void *handle) {
    mock_object *const object = (mock_object *)handle;
    if (!object) return;
    --object->inner;
    end_if_unheld(object);
}

cl_int mock_retain(const char *name, void *handle, mock_kind kind, cl_int invalid) {
    const cl_int refused = mock_enter(name, 0);
    if (refused) return refused;
    mock_lock();
    const bool is = mock_is_locked(handle, kind);
    if (is) ++((mock_object *)handle)->refs;
    mock_unlock();
    return is ? CL_SUCCESS : invalid;
}

cl_int mock_release(const char *name, void *handle, mock_kind kind, cl_int invalid) {
    const cl_int refused = mock_enter(name, 0);
    mock_lock();
    const bool is = mock_is_locked(handle, kind);
    if (is) {
        --((mock_object *)handle)->refs;
        end_if_unheld((mock_object *)handle);
    } else {
        (void)mock_mistake_locked(invalid, name);
    }
    mock_unlock();
    return is ? refused : invalid;
}

/* ---- Counts --------------------------------------------------------------------------------- */

void mock_count_bytes_locked(int64_t bytes) {
    live_bytes += bytes;
}

void mock_count_pending_locked(int change) {
    pending += change;
}

void mock_note_launch(size_t group) {
    mock_lock();
    last_group = group;
    if (meeting && --meeting == 0) pthread_cond_broadcast(&all_met);
    while (meeting) pthread_cond_wait(&all_met, &books);
    mock_unlock();
}

void mock_meet(uint32_t threads) {
    mock_lock();
    meeting = threads;
    mock_unlock();
}

void mock_count_shared_buffer(void) {
    mock_lock();
    ++shared_buffers;
    mock_unlock();
}

uint64_t mock_live(mock_kind kind) {
    uint64_t count = 0;
    mock_lock();
    for (const mock_object *o = objects; o; o = o->next) count += o->kind == kind && o->refs > 0;
    mock_unlock();
    return count;
}

uint64_t mock_live_all(void) {
    uint64_t count = 0;
    mock_lock();
    for (const mock_object *o = objects; o; o = o->next) ++count;
    mock_unlock();
    return count;
}

uint64_t mock_live_bytes(void) {
    mock_lock();
    const int64_t bytes = live_bytes;
    mock_unlock();
    return (uint64_t)bytes;
}

size_t mock_last_group(void) {
    return last_group;
}

uint64_t mock_shared_buffers(void) {
    return shared_buffers;
}

void mock_reset(void) {
    mock_lock();
    if (objects) (void)mock_mistake_locked(CL_SUCCESS, "mock_reset with live objects");
    if (!objects) {
        mistakes = 0;
        first_mistake = "";
    }
    mock_now = mock_usual_world();
    shared_buffers = last_group = 0;
    mock_unlock();
    mock_fail(0, CL_SUCCESS, false);
}

/* ---- Answers -------------------------------------------------------------------------------- */

cl_int mock_give(size_t size, void *value, size_t *size_ret, const void *data, size_t bytes) {
    if (value && size < bytes) return CL_INVALID_VALUE;
    if (value) memcpy(value, data, bytes);
    if (size_ret) *size_ret = bytes;
    return CL_SUCCESS;
}

cl_int mock_give_text(size_t size, void *value, size_t *size_ret, const char *text) {
    return mock_give(size, value, size_ret, text, strlen(text) + 1);
}

void *mock_created(cl_int *code_ret, cl_int code, void *handle) {
    if (code_ret) *code_ret = code;
    return handle;
}
