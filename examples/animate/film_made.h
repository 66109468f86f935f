/* film_made.h: films made by rule, for where there is no file: a crowd that walks, a mesh that
 * explodes, a flag in the wind. */
#ifndef EXAMPLES_FILM_MADE_H
#define EXAMPLES_FILM_MADE_H

#include "film.h"
#include "shapes.h"

/* A film of about `triangles` triangles. explode tears `mesh`, or a knot if it is NULL, and takes
 * the size from it. False: no such film, or no memory. */
bool film_make(film *out, const char *name, uint64_t triangles, const shape *mesh);

/* Names, ending in NULL. */
const char *const *film_names(void);

/* What every made film has, for the makers: film->data points to it. */
typedef struct film_made {
    shape rest;                      /* where the vertices are before anything moves */
    uint32_t *material;              /* one per triangle */
    void *parts;                     /* the maker's own */
    double centre[3], eye[3], orbit; /* the view turns around the centre, `orbit` turns in all */
} film_made;

bool film_make_crowd(film *f, film_made *made, uint64_t triangles);
bool film_make_cloth(film *f, film_made *made, uint64_t triangles);
bool film_make_burst(film *f, film_made *made, const shape *mesh);

#endif
