/* film.h: an animation, from a file or made by rule: arrays that keep their length and triangles
 * while time moves the vertices. */
#ifndef EXAMPLES_FILM_H
#define EXAMPLES_FILM_H

#include "camera.h"
#include "cone.h"

#include <stddef.h>

typedef struct film_material {
    float colour[3]; /* as a matt surface, linear */
} film_material;

typedef struct film_light {
    double at[3];
    float colour[3];
} film_light;

/* One moment of a film: what time changes. */
typedef struct film_frame {
    float *positions; /* film->vertex_count of them */
    cone *cones;
    htree_box *boxes; /* of the cones */
    htree_objects objects;
} film_frame;

typedef struct film film;

/* What every kind of film must tell; whoever makes a film fills it in. */
struct film {
    const char *name;
    double from, to; /* seconds, and the frames that the maker had in mind */
    uint32_t frames;
    uint64_t primitives; /* as the paper counts: a polygon is one, not its triangles */
    uint64_t vertex_count, triangle_count, cone_count;
    const uint32_t *indices;  /* three per triangle */
    const uint32_t *material; /* one per triangle, then one per cone */
    const film_material *materials;
    const film_light *lights;
    uint32_t light_count;
    float background[3];
    float ambient; /* light from everywhere, 0 to 1 */

    /* On so many threads; false: no memory. */
    bool (*pose)(const film *f, double time, uint32_t threads, film_frame *frame);
    void (*view)(const film *f, double time, double aspect, camera *out);
    void (*release)(film *f);
    void *data;
};

/* Opens a film by name: crowd, explode or cloth, with an optional :TRIANGLES, else the path of an
 * AFF file. `mesh` is a mesh file for explode, or NULL. False writes one line to `error`. */
typedef struct film_wish {
    const char *scene, *mesh;
    uint32_t split;       /* AFF: animated triangles are split 4-way so many times */
    bool keep_coincident; /* AFF: keep triangles with two corners in one place */
} film_wish;
bool film_open(film *out, const film_wish *wish, char *error, size_t size);
void film_close(film *f);

/* Arrays for one moment; false: no memory. */
bool film_frame_make(film_frame *out, const film *f);
void film_frame_free(film_frame *frame);

/* The mesh of a posed frame, borrowed from it and from the film. */
htree_mesh film_mesh(const film *f, const film_frame *frame);

#endif
