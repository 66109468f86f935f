/* aff_read.h: the state of a reader, shared by the files that read statements. */
#ifndef EXAMPLES_AFF_READ_H
#define EXAMPLES_AFF_READ_H

#include "aff_lexer.h"
#include "aff_scene.h"

/* A file that is being read, and the one that included it. */
typedef struct aff_source {
    aff_lexer lexer;
    const struct aff_source *outer;
} aff_source;

typedef struct aff_reader {
    aff_scene *scene;
    const aff_options *options;
    aff_error *error;
    aff_lexer *lexer; /* of the innermost source */
    const aff_source *source;
    uint32_t node; /* what is read now hangs below this transform */
    uint32_t depth, includes;
} aff_reader;

/* All of these are false after an error, which is written then. */
bool aff_read_file(aff_reader *r, const char *path);
bool aff_no_memory(aff_reader *r);

/* The motion called `name`, made without keys if it is new. */
bool aff_find_motion(aff_reader *r, aff_word name, int32_t *index);

/* The statements k; m; p and pp; tt and ttp; c; tpa. `numbers` is how many a corner has, of which
 * the first three are its position. */
bool aff_read_keys(aff_reader *r);
bool aff_read_mesh(aff_reader *r);
bool aff_read_polygon(aff_reader *r, uint32_t numbers);
bool aff_read_textured(aff_reader *r, uint32_t numbers);
bool aff_read_cone(aff_reader *r);
bool aff_read_patch(aff_reader *r);

#endif
