/* anim_shade.h: a picture of one frame: matt surfaces under the film's lights, with shadows. */
#ifndef EXAMPLES_ANIM_SHADE_H
#define EXAMPLES_ANIM_SHADE_H

#include "film.h"
#include "picture.h"

/* Paints with samples x samples rays per pixel. HTREE_ERROR_MEMORY may be the painter's own. */
htree_status anim_shade(picture *out, const film *f, const film_frame *frame, const htree *tree,
                        const camera *view, uint32_t samples, uint32_t threads);

#endif
