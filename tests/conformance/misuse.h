/* misuse.h: of the conformance file: statuses by name, and calls that must fail. */
#ifndef TESTS_MISUSE_H
#define TESTS_MISUSE_H

#include "suite.h"

#include <stdio.h>

/* A failure outside a running test ends the program with a status that is not 0. */
#define DEMAND(condition, ...)                                                                     \
    do {                                                                                           \
        if (!(condition)) fail_msg(__VA_ARGS__);                                                   \
    } while (0)

/* That the table of statuses has all of the library's; writes them and their names. */
void check_statuses(void);
void put_statuses(FILE *to);

/* That every misuse is refused as the file promises; writes what it promises. `soup` takes long
 * enough to build to be cancelled, and `many` leaves a lazy tree something to do. */
void check_misuses(const htree_mesh *soup, const htree_mesh *many);
void put_misuses(FILE *to);

#endif
