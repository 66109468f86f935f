/* config.h: how a contender builds, by name: "fast+lazy" of ours, "embree-low-robust" of a peer. */
#ifndef EXAMPLES_CONFIG_H
#define EXAMPLES_CONFIG_H

#include "htree.h"

#include <stdbool.h>

typedef struct tree_config {
    char name[32];
    htree_kind kind;
    uint32_t flags; /* beside those of the kind */
} tree_config;

typedef enum peer_quality { PEER_LOW, PEER_MEDIUM, PEER_HIGH, PEER_REFIT } peer_quality;

typedef struct peer_config {
    char name[32]; /* "low", "medium-robust" */
    peer_quality quality;
    bool robust, compact;
} peer_config;

/* KIND[+lazy][+morton][+compact][+collapse]. `program` begins the line on stderr that says what is
 * wrong. */
bool tree_config_read(const char *program, tree_config *out, const char *text);

/* embree[-low|-medium|-high|-refit][-robust][-compact]: medium is left out. */
bool peer_config_read(const char *program, peer_config *out, const char *text);

#endif
