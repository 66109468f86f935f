#include "arena.h"

enum { FIRST_BLOCK_BYTES = 1 << 14, ITEM_ALIGNMENT = 16 };

void ht_stack_begin(ht_stack_memory *stack, ht_memory *memory) {
    memset(stack, 0, sizeof *stack);
    stack->memory = memory;
}

void ht_stack_end(ht_stack_memory *stack) {
    for (uint32_t i = 0; i < stack->blocks; ++i) {
        ht_release(stack->memory, stack->block[i].bytes, stack->block[i].size);
    }
    stack->blocks = 0;
}

/* Every block is at least twice the one before, so the blocks of the table are never used up. */
static bool add_block(ht_stack_memory *stack, uint64_t bytes) {
    uint64_t size = stack->blocks ? 2 * stack->block[stack->blocks - 1].size : FIRST_BLOCK_BYTES;
    if (size < bytes) size = bytes;
    assert(stack->blocks < HT_STACK_BLOCKS);
    char *memory = (char *)ht_allocate(stack->memory, size);
    if (!memory) return false;
    stack->block[stack->blocks].bytes = memory;
    stack->block[stack->blocks].size = size;
    stack->block[stack->blocks].used = 0;
    ++stack->blocks;
    return true;
}

void *ht_stack_push(ht_stack_memory *stack, uint64_t bytes) {
    bytes = (bytes + ITEM_ALIGNMENT - 1) / ITEM_ALIGNMENT * ITEM_ALIGNMENT;
    if (stack->blocks == 0 && !add_block(stack, bytes)) return NULL;
    while (stack->block[stack->top].size - stack->block[stack->top].used < bytes) {
        if (stack->top + 1 == stack->blocks && !add_block(stack, bytes)) return NULL;
        ++stack->top;
        assert(stack->block[stack->top].used == 0);
    }
    void *pushed = stack->block[stack->top].bytes + stack->block[stack->top].used;
    stack->block[stack->top].used += bytes;
    return pushed;
}

void ht_stack_trim(ht_stack_memory *stack, const void *pushed, uint64_t bytes) {
    bytes = (bytes + ITEM_ALIGNMENT - 1) / ITEM_ALIGNMENT * ITEM_ALIGNMENT;
    const uint64_t start = (uint64_t)((const char *)pushed - stack->block[stack->top].bytes);
    assert(start + bytes <= stack->block[stack->top].used);
    stack->block[stack->top].used = start + bytes;
}

ht_stack_mark ht_stack_top(const ht_stack_memory *stack) {
    const ht_stack_mark mark = {stack->top, stack->blocks ? stack->block[stack->top].used : 0};
    return mark;
}

void ht_stack_pop(ht_stack_memory *stack, ht_stack_mark mark) {
    while (stack->top > mark.top) stack->block[stack->top--].used = 0;
    if (stack->blocks) stack->block[stack->top].used = mark.used;
}

void ht_array_begin(ht_array *array, ht_memory *memory, uint64_t item_bytes) {
    memset(array, 0, sizeof *array);
    array->memory = memory;
    array->item_bytes = item_bytes;
}

void ht_array_end(ht_array *array) {
    ht_release(array->memory, array->items, array->capacity * array->item_bytes);
    array->items = NULL;
}

static bool grow(ht_array *array) {
    const uint64_t capacity = array->capacity ? 2 * array->capacity : 64;
    char *items = (char *)ht_allocate(array->memory, capacity * array->item_bytes);
    if (!items) return false;
    if (array->items) memcpy(items, array->items, (size_t)(array->count * array->item_bytes));
    ht_array_end(array);
    array->items = items;
    array->capacity = capacity;
    return true;
}

htree_status ht_array_reserve(ht_array *array, uint64_t capacity) {
    assert(array->capacity == 0);
    array->items = (char *)ht_allocate(array->memory, capacity * array->item_bytes);
    if (!array->items) return HTREE_ERROR_MEMORY;
    array->capacity = capacity;
    return HTREE_OK;
}

void *ht_array_add(ht_array *array) {
    if (array->count == array->capacity && !grow(array)) return NULL;
    void *item = ht_array_at(array, array->count++);
    memset(item, 0, (size_t)array->item_bytes);
    return item;
}

htree_status ht_array_finish(const ht_array *array, void **items) {
    const uint64_t bytes = array->count * array->item_bytes;
    *items = ht_allocate(array->memory, bytes);
    if (!*items) return HTREE_ERROR_MEMORY;
    if (bytes) memcpy(*items, array->items, (size_t)bytes);
    return HTREE_OK;
}
