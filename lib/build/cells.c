#include "cells.h"

enum { MOST_CELLS_PER_AXIS = 1 << 20 };

static uint32_t cells_along(double extent, double side) {
    const double cells = extent / side;
    return cells < 1 ? 1 : cells < MOST_CELLS_PER_AXIS ? (uint32_t)cells : MOST_CELLS_PER_AXIS;
}

/* By bisection: an axis thinner than a cell has one cell, so there is no closed form, and no
 * cube root is needed, which libraries round differently. */
void ht_cubic_cells(const htree_box *box, double wanted, uint32_t cells[3], float size[3]) {
    double extent[3], large = 0;
    for (int i = 0; i < 3; ++i) {
        extent[i] = (double)box->hi[i] - (double)box->lo[i];
        if (extent[i] > large) large = extent[i];
    }
    double small = large / MOST_CELLS_PER_AXIS;
    for (int step = 0; step < 40; ++step) {
        const double side = (small + large) / 2;
        double count = 1;
        for (int i = 0; i < 3; ++i) count *= (double)cells_along(extent[i], side);
        if (count > wanted) {
            small = side;
        } else {
            large = side;
        }
    }
    for (int i = 0; i < 3; ++i) {
        cells[i] = cells_along(extent[i], large);
        size[i] = (float)(extent[i] / (double)cells[i]);
    }
}
