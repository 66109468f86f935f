/* search.c: interpolation-binary search (N. Santoro, J. B. Sidney, 1985) for the minimum of eq.
 * 2.
 *
 * From left to right the expected cost of the left side rises and that of the right side falls.
 * Their difference is monotonic, and the minimum of their sum lies where it changes sign or
 * next to it: so the sign change is searched, and its neighbours are compared. Every other step
 * halves the range, so there are at most 2 log2 M steps for any distribution. */
#include "search.h"

typedef struct cut_costs {
    float left, right;
    uint32_t left_count;
} cut_costs;

typedef struct cut_search {
    const ht_grid *grid;
    const ht_cells *cells;
    const htree_box *box;
    uint32_t axis, count;
} cut_search;

static float plane_position(const cut_search *s, float plane) {
    return s->grid->origin[s->axis] / 2 + plane * s->grid->size[s->axis];
}

static cut_costs costs_at(const cut_search *s, uint32_t plane) {
    ht_cells left_cells = *s->cells;
    htree_box left = *s->box, right = *s->box;
    cut_costs costs;
    left_cells.end[s->axis] = plane;
    left.hi[s->axis] = ht_min(left.hi[s->axis], plane_position(s, (float)plane + 0.5f));
    right.lo[s->axis] = ht_max(right.lo[s->axis], plane_position(s, (float)plane - 0.5f));
    costs.left_count = ht_grid_count(s->grid, &left_cells);
    costs.left = (float)costs.left_count * ht_box_area(&left);
    costs.right = (float)(s->count - costs.left_count) * ht_box_area(&right);
    return costs;
}

/* The first plane at which the left side costs more than the right one, or the last plane. */
static uint32_t find_balance(const cut_search *s, uint32_t low, uint32_t high) {
    cut_costs at_low = costs_at(s, low), at_high = costs_at(s, high);
    for (bool interpolate = true; low + 1 < high; interpolate = !interpolate) {
        const float below = at_low.left - at_low.right, above = at_high.left - at_high.right;
        if (below >= 0) return low;
        if (above <= 0) return high;
        uint32_t middle = low + (high - low) / 2;
        if (interpolate) {
            middle = low + (uint32_t)((float)(high - low) * (below / (below - above)));
            middle = middle <= low ? low + 1 : middle >= high ? high - 1 : middle;
        }
        const cut_costs at_middle = costs_at(s, middle);
        if (at_middle.left < at_middle.right) {
            low = middle;
            at_low = at_middle;
        } else {
            high = middle;
            at_high = at_middle;
        }
    }
    return high;
}

void ht_find_cut(const ht_grid *grid, const ht_cells *cells, uint32_t count, const htree_box *box,
                 ht_cut *cut) {
    cut_search s = {grid, cells, box, 0, count};
    float widest = 0;
    for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t slabs = cells->end[i] - cells->first[i];
        const float width = (float)slabs * grid->size[i];
        if (slabs > 1 && width > widest) {
            widest = width;
            s.axis = i;
        }
    }
    const uint32_t first = cells->first[s.axis] + 1, last = cells->end[s.axis] - 1;
    const uint32_t balance = find_balance(&s, first, last);
    float cheapest = INFINITY;
    cut->axis = s.axis;
    cut->plane = balance;
    for (uint32_t plane = balance > first ? balance - 1 : first;
         plane <= balance + 1 && plane <= last; ++plane) {
        const cut_costs costs = costs_at(&s, plane);
        if (costs.left + costs.right < cheapest || plane == first) {
            cheapest = costs.left + costs.right;
            cut->plane = plane;
            cut->left_count = costs.left_count;
        }
    }
    cut->left_hi = ht_min(box->hi[s.axis], plane_position(&s, (float)cut->plane + 0.5f));
    cut->right_lo = ht_max(box->lo[s.axis], plane_position(&s, (float)cut->plane - 0.5f));
}
