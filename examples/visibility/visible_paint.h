/* visible_paint.h: the scene with its triangles coloured by how the view cell sees them. */
#ifndef EXAMPLES_VISIBLE_PAINT_H
#define EXAMPLES_VISIBLE_PAINT_H

#include "picture.h"
#include "visible.h"
#include "visible_args.h"

/* Shaded as by htree-render, tinted by marks, with the cell's edges and a legend. */
htree_status visible_paint(picture *out, const visible_job *job, const visible_result *result,
                           const camera *view, const visible_args *args);

#endif
