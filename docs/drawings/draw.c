/* draw.c: draw KIND: the tree of that kind over a small flat scene, as an SVG on stdout: every leaf's
 * triangles, and around them what the tree knows of the space where they lie. From htree_get_view,
 * as its nodes really are. */
#include <htree.h>
#include <layout.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TRIANGLES = 26, SIZE = 640 };

typedef struct rect {
    float lo[2], hi[2];
} rect;

/* ---- A scene: a row of tiles, a fan, a long beam, and a few that are far apart -------------- */

static float corners[9 * TRIANGLES];
static unsigned made;

static void add(float ax, float ay, float bx, float by, float cx, float cy) {
    const float p[9] = {ax, ay, 0, bx, by, 0, cx, cy, 0};
    memcpy(corners + 9 * made++, p, sizeof p);
}

static void make_scene(void) {
    for (int i = 0; i < 6; ++i) { /* tiles */
        const float x = 4 + 5 * (float)i, y = 6 + 2 * sinf((float)i);
        add(x, y, x + 4.5f, y, x, y + 4.5f);
        add(x + 4.5f, y, x + 4.5f, y + 4.5f, x, y + 4.5f);
    }
    for (int i = 0; i < 8; ++i) { /* fan */
        const float a = 0.78f * (float)i, b = a + 0.6f;
        add(48, 44, 48 + 9 * cosf(a), 44 + 9 * sinf(a), 48 + 9 * cosf(b), 44 + 9 * sinf(b));
    }
    add(6, 24, 58, 27, 58, 28.5f); /* beam */
    for (int i = 0; made < TRIANGLES; ++i) {
        const float x = 6 + 7.5f * (float)(i % 3),
                    y = 36 + 12 * (float)(i / 3) + 3 * (float)(i % 2);
        add(x, y, x + 3, y + 1, x + 1, y + 4);
    }
}

/* ---- SVG ------------------------------------------------------------------------------------ */

static const char *const shade[] = {"#1b6ca8", "#3a9c7d", "#c77d1e",
                                    "#b13f5c", "#6b4ea0", "#6d6d6d"};

static double at(float x) {
    return (double)x * SIZE / 64;
}

static void draw_rect(const rect *r, unsigned level, const char *more) {
    const double inset = 1.2 * (level < 6 ? level : 6);
    const double w = at(r->hi[0]) - at(r->lo[0]), h = at(r->hi[1]) - at(r->lo[1]);
    if (!(w > 0 && h > 0)) return;
    printf("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='none' stroke='%s' "
           "stroke-width='%.1f' %s/>\n",
           at(r->lo[0]) + inset, at(r->lo[1]) + inset, fmax(w - 2 * inset, 1),
           fmax(h - 2 * inset, 1), shade[level % 6], level < 2 ? 2.5 : 1.5, more);
}

static void draw_triangles(void) {
    for (unsigned i = 0; i < TRIANGLES; ++i) {
        const float *p = corners + 9 * i;
        printf(
            "<polygon points='%.1f,%.1f %.1f,%.1f %.1f,%.1f' fill='#d9d4c7' stroke='#77705f'/>\n",
            at(p[0]), at(p[1]), at(p[3]), at(p[4]), at(p[6]), at(p[7]));
    }
}

/* ---- Nodes ---------------------------------------------------------------------------------- */

static rect rect_of(const float *lo, const float *hi) {
    const rect r = {{lo[0], lo[1]}, {hi[0], hi[1]}};
    return r;
}

static void draw_bvh(const ht_bvh_node *nodes, unsigned slot, unsigned level) {
    const ht_bvh_node *node = &nodes[slot];
    const rect box = rect_of(node->lo, node->hi);
    if (node->tag == HT_BVH_LEAF) return;
    draw_rect(&box, level, "");
    draw_bvh(nodes, node->child, level + 1);
    draw_bvh(nodes, node->child + 1, level + 1);
}

static void draw_kd(const ht_kd_node *nodes, unsigned slot, rect voxel, unsigned level) {
    const ht_kd_node *node = &nodes[slot];
    const unsigned axis = node->tag & 3;
    if (axis == HT_KD_LEAF) return;
    rect left = voxel, right = voxel;
    if (axis < 2) {
        left.hi[axis] = right.lo[axis] = node->plane;
        const rect line = {{right.lo[0], right.lo[1]}, {left.hi[0], left.hi[1]}};
        printf("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' stroke='%s' stroke-width='%.1f'/>\n",
               at(line.lo[0]), at(line.lo[1]), at(line.hi[0]), at(line.hi[1]), shade[level % 6],
               level < 2 ? 3.0 : 1.5);
    }
    draw_kd(nodes, slot + 1, left, level + 1);
    draw_kd(nodes, node->tag >> 2, right, level + 1);
}

static void draw_h(const ht_h_node *nodes, unsigned slot, rect region, unsigned level);

static void draw_skd(const ht_h_node *nodes, unsigned slot, rect region, unsigned level) {
    const ht_h_node *node = &nodes[slot];
    const unsigned axis = (node->tag & HT_H_TYPE) - HT_H_SKD, shelf = node->tag >> HT_H_TAG_BITS;
    rect left = region, right = region;
    if (axis < 2) {
        left.hi[axis] = node->a;
        right.lo[axis] = node->b;
        draw_rect(&left, level, "");
        draw_rect(&right, level, "");
    }
    draw_h(nodes, slot + 1, left, level + 1);
    draw_h(nodes, node->child, right, level + 1);
    if (shelf) draw_h(nodes, shelf, region, level + 1);
}

/* Bounding nodes are dashed. */
static void draw_bound(const ht_h_node *nodes, unsigned slot, rect region, unsigned level) {
    const ht_h_node *node = &nodes[slot];
    const unsigned type = node->tag & HT_H_TYPE, slots = type == HT_H_BV6 ? 2 : 1;
    if (type == HT_H_BV6) {
        const rect box = {{node[0].a, node[0].b}, {node[1].a, node[1].b}};
        region = box;
    } else if (type - HT_H_BV2 < 2) {
        region.lo[type - HT_H_BV2] = node->a;
        region.hi[type - HT_H_BV2] = node->b;
    }
    draw_rect(&region, level, "stroke-dasharray='7 4'");
    draw_h(nodes, slot + slots, region, level);
}

static void draw_h(const ht_h_node *nodes, unsigned slot, rect region, unsigned level) {
    const unsigned type = nodes[slot].tag & HT_H_TYPE;
    if (type == HT_H_LINK) {
        draw_h(nodes, nodes[slot].child, region, level);
    } else if (type >= HT_H_BV2) {
        draw_bound(nodes, slot, region, level);
    } else if (type != HT_H_LEAF) {
        draw_skd(nodes, slot, region, level);
    }
}

static void draw_wide(const ht_wide_node *nodes, unsigned slot, unsigned level) {
    const ht_wide_node *node = &nodes[slot];
    for (unsigned lane = 0; lane < HT_LANES; ++lane) {
        const rect box = {{node->lo[0][lane], node->lo[1][lane]},
                          {node->hi[0][lane], node->hi[1][lane]}};
        if (node->child[lane] == HT_WIDE_NONE) continue;
        draw_rect(&box, level, node->child[lane] & HT_WIDE_LEAF ? "stroke-dasharray='7 4'" : "");
        if (!(node->child[lane] & HT_WIDE_LEAF)) draw_wide(nodes, node->child[lane], level + 1);
    }
}

static void draw_grid(const ht_ug_grid *grid) {
    for (unsigned y = 0; y < grid->cells[1]; ++y) {
        for (unsigned x = 0; x < grid->cells[0]; ++x) {
            const float left = grid->lo[0] + (float)x * grid->size[0];
            const float top = grid->lo[1] + (float)y * grid->size[1];
            const rect cell = {{left, top}, {left + grid->size[0], top + grid->size[1]}};
            draw_rect(&cell, 0, "stroke-opacity='0.5'");
        }
    }
}

static void draw_tree(const htree_view *view) {
    const rect all = rect_of(view->bounds.lo, view->bounds.hi);
    switch (view->kind) {
    case HTREE_UG: draw_grid((const ht_ug_grid *)view->grid); break;
    case HTREE_KD: draw_kd((const ht_kd_node *)view->nodes, 0, all, 0); break;
    case HTREE_WIDE: draw_wide((const ht_wide_node *)view->nodes, 0, 0); break;
    case HTREE_BVH_MEDIAN:
    case HTREE_BVH_SAH: draw_bvh((const ht_bvh_node *)view->nodes, 0, 0); break;
    default: draw_h((const ht_h_node *)view->nodes, 0, all, 0);
    }
}

int main(int argc, char **argv) {
    htree_options options;
    htree_view view = {.size = sizeof view};
    htree *tree = NULL;
    make_scene();
    const htree_mesh mesh = {
        .positions = corners, .vertex_count = 3 * TRIANGLES, .triangle_count = TRIANGLES};
    if (htree_options_init(&options, sizeof options,
                           htree_kind_from_name(argc > 1 ? argv[1] : ""))) {
        fprintf(stderr, "draw KIND: %s\n", htree_error_text());
        return 2;
    }
    options.few_prims = 4; /* so that so small a scene has a grid at all */
    if (htree_build(&tree, &mesh, &options) || htree_get_view(tree, &view)) {
        fprintf(stderr, "draw: %s\n", htree_error_text());
        htree_free(tree);
        return 1;
    }
    printf(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-4 -4 %d %d' width='420' height='420'>\n"
        "<rect x='-4' y='-4' width='100%%' height='100%%' fill='white'/>\n",
        SIZE + 8, SIZE + 8);
    draw_triangles();
    draw_tree(&view);
    printf("</svg>\n");
    htree_free(tree);
    return 0;
}
