/* list.h: arrays that grow. LIST_OF(point, double) makes the type point_list, which starts from
 * zero, and point_push. */
#ifndef EXAMPLES_LIST_H
#define EXAMPLES_LIST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* push: false if there is no memory; then the list is as it was. Free `at` with free. */
#define LIST_OF(name, type)                                                                        \
    typedef struct name##_list {                                                                   \
        type *at;                                                                                  \
        size_t count, room;                                                                        \
    } name##_list;                                                                                 \
    static inline bool name##_push(name##_list *list, type item) {                                 \
        if (list->count == list->room) {                                                           \
            const size_t room = list->room ? 2 * list->room : 16;                                  \
            if (room > SIZE_MAX / 2 / sizeof item) return false;                                   \
            type *larger = (type *)realloc(list->at, room * sizeof item);                          \
            if (!larger) return false;                                                             \
            list->at = larger;                                                                     \
            list->room = room;                                                                     \
        }                                                                                          \
        list->at[list->count++] = item;                                                            \
        return true;                                                                               \
    }

#endif
