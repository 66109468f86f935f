/* arena.h: memory of unknown size, as builders need it: a stack of blocks, and a growing array. */
#ifndef HT_ARENA_H
#define HT_ARENA_H

#include "memory.h"

/* ---- A stack: pushed memory never moves, and goes back in reverse order --------------------- */

enum { HT_STACK_BLOCKS = 48 };

typedef struct ht_stack_memory {
    ht_memory *memory;
    struct {
        char *bytes;
        uint64_t size, used;
    } block[HT_STACK_BLOCKS];
    uint32_t blocks, top; /* blocks held; the one that is being filled */
} ht_stack_memory;

typedef struct ht_stack_mark {
    uint32_t top;
    uint64_t used;
} ht_stack_mark;

void ht_stack_begin(ht_stack_memory *stack, ht_memory *memory);
void ht_stack_end(ht_stack_memory *stack);

/* NULL after recording the failure's text. Aligned to 16 bytes. */
void *ht_stack_push(ht_stack_memory *stack, uint64_t bytes);

/* Shrinks what was pushed last. */
void ht_stack_trim(ht_stack_memory *stack, const void *pushed, uint64_t bytes);

ht_stack_mark ht_stack_top(const ht_stack_memory *stack);
void ht_stack_pop(ht_stack_memory *stack, ht_stack_mark mark);

/* ---- An array that grows by doubling -------------------------------------------------------- */

typedef struct ht_array {
    ht_memory *memory;
    char *items;
    uint64_t item_bytes, count, capacity;
} ht_array;

void ht_array_begin(ht_array *array, ht_memory *memory, uint64_t item_bytes);
void ht_array_end(ht_array *array);

/* Room for so many items, if there are none yet. */
htree_status ht_array_reserve(ht_array *array, uint64_t capacity);

/* A new item, zeroed; NULL after recording the failure's text. Earlier items may move. */
void *ht_array_add(ht_array *array);

HT_INLINE void *ht_array_at(const ht_array *array, uint64_t index) {
    return array->items + index * array->item_bytes;
}

/* Copies the items into memory of just their size, which the caller then owns. */
htree_status ht_array_finish(const ht_array *array, void **items);

#endif
