/* nodes.c: htree-nodes. The nodes of trees over one mesh, as JSON for viewers: docs/gallery draws them.
 *
 * SPDX-License-Identifier: MIT */
#include "mesh_file.h"
#include "option.h"
#include "report.h"
#include "shape_mesh.h"
#include "tree_nodes.h"
#include "whole_file.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_INPUT = 1, EXIT_USAGE = 2, MOST_KINDS = 8 };

static const char program[] = "htree-nodes";

static const char help[] =
    "usage: htree-nodes [OPTION]... [MESH]\n"
    "\n"
    "Writes the nodes of trees over MESH or a built-in scene as JSON: of each its type, level,\n"
    "and box; and the triangles. For thousands of triangles rather than millions.\n"
    "\n"
    "      --kind LIST         ug kd bvh-median bvh-sah skd h ah wide (default h)\n"
    "      --scene NAME[:N]    built-in scene of about N triangles (default knot:1500)\n"
    "  -o, --output FILE       (default: standard output)\n"
    "  -h, --help   -V, --version\n"
    "\n"
    "  htree-nodes -o knot.json\n"
    "  htree-nodes --scene city:2000 --kind h,ah,wide -o city.json\n"
    "  htree-nodes teapot.ply --kind kd | jq '.trees[0].nodes | map_values(.level | length)'\n";

static const struct option long_options[] = {
    {"kind", required_argument, NULL, 'k'},   {"scene", required_argument, NULL, 's'},
    {"output", required_argument, NULL, 'o'}, {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},      {NULL, 0, NULL, 0},
};

typedef struct nodes_args {
    const char *mesh_path, *output; /* NULL: the built-in scene, standard output */
    char scene[32];
    uint64_t triangles;
    htree_kind kinds[MOST_KINDS];
    uint32_t kind_count;
} nodes_args;

/* ---- Arguments ------------------------------------------------------------------------------ */

static bool take_kind(void *user, const char *name) {
    nodes_args *out = (nodes_args *)user;
    return option_kind_add(program, "kind", name, out->kinds, &out->kind_count, MOST_KINDS);
}

static bool take_option(nodes_args *out, int option, const char *value) {
    switch (option) {
    case 'k': return option_list(program, "kind", value, take_kind, out);
    case 's': return option_scene(program, value, out->scene, &out->triangles);
    default: return option_output(program, "output", value, &out->output);
    }
}

static args_result parse(nodes_args *out, int argc, char **argv) {
    bool scene = false;
    memset(out, 0, sizeof *out);
    option_shape("knot:1500", out->scene, &out->triangles);
    const option_syntax syntax = {program, help, ":o:hV", long_options};
    args_result result;
    for (int option; (option = option_next(&syntax, argc, argv, &result)) != -1;) {
        if (!take_option(out, option, optarg)) return ARGS_WRONG;
        scene = scene || option == 's';
    }
    if (result != ARGS_RUN) return result;
    if (!out->kind_count) out->kinds[out->kind_count++] = HTREE_H;
    return option_one_mesh(program, argc, argv, scene, &out->mesh_path) ? ARGS_RUN : ARGS_WRONG;
}

/* ---- JSON ----------------------------------------------------------------------------------- */

static void write_box(FILE *file, const htree_box *box) {
    fprintf(file, "%.7g,%.7g,%.7g,%.7g,%.7g,%.7g", (double)box->lo[0], (double)box->lo[1],
            (double)box->lo[2], (double)box->hi[0], (double)box->hi[1], (double)box->hi[2]);
}

/* The nodes of one type: their levels, and six planes for each. False if there are none. */
static bool write_type(FILE *file, const tree_nodes *list, node_type type, const char *before) {
    uint64_t count = 0;
    for (uint64_t i = 0; i < list->count; ++i) {
        if (list->node[i].type != type) continue;
        if (!count++) fprintf(file, "%s\n   \"%s\": {\"level\": [", before, node_type_name(type));
        fprintf(file, count > 1 ? ",%u" : "%u", (unsigned)list->node[i].level);
    }
    if (!count) return false;
    fputs("],\n    \"box\": [", file);
    for (uint64_t i = 0, written = 0; i < list->count; ++i) {
        if (list->node[i].type != type) continue;
        if (written++) fputs(",", file);
        write_box(file, &list->node[i].box);
    }
    fputs("]}", file);
    return true;
}

static void write_tree(FILE *file, const tree_nodes *list, const htree_stats *stats) {
    fprintf(file, "{\"kind\": \"%s\", \"bytes\": %llu, \"levels\": %u, \"nodes\": {",
            htree_kind_name(stats->kind), (unsigned long long)stats->bytes,
            (unsigned)tree_nodes_levels(list));
    bool any = false;
    for (int type = 0; type < NODE_TYPES; ++type)
        any = write_type(file, list, (node_type)type, any ? "," : "") || any;
    fputs("}}", file);
}

static void write_mesh(FILE *file, const char *name, const shape *mesh) {
    fputs("{\"scene\": ", file);
    report_write_string(file, name);
    fprintf(file, ",\n \"triangles\": %llu,\n \"positions\": [",
            (unsigned long long)mesh->triangle_count);
    for (uint64_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const float *p = mesh->positions + 3 * (size_t)mesh->indices[i];
        fprintf(file, "%s%.7g,%.7g,%.7g", i ? "," : "", (double)p[0], (double)p[1], (double)p[2]);
    }
    fputs("],\n \"trees\": [\n  ", file);
}

/* ---- The whole ------------------------------------------------------------------------------ */

static htree_status build_and_write(FILE *file, const shape *s, htree_kind kind) {
    const htree_mesh mesh = shape_mesh(s);
    htree_stats stats = {.size = sizeof stats};
    htree_options options;
    tree_nodes list = {0};
    htree *tree = NULL;
    htree_status status = htree_options_init(&options, sizeof options, kind);
    if (status == HTREE_OK) status = htree_build(&tree, &mesh, &options);
    if (status == HTREE_OK) status = htree_get_stats(tree, &stats);
    if (status == HTREE_OK) status = tree_nodes_list(&list, tree);
    if (status == HTREE_OK) write_tree(file, &list, &stats);
    tree_nodes_free(&list);
    htree_free(tree);
    return status;
}

static bool write_all(FILE *file, const nodes_args *args, const shape *mesh, char *error,
                      size_t size) {
    htree_status status = HTREE_OK;
    write_mesh(file, args->mesh_path ? args->mesh_path : args->scene, mesh);
    for (uint32_t i = 0; status == HTREE_OK && i < args->kind_count; ++i) {
        if (i) fputs(",\n  ", file);
        status = build_and_write(file, mesh, args->kinds[i]);
    }
    fputs("\n ]}\n", file);
    if (status != HTREE_OK) snprintf(error, size, "%s", htree_error_text());
    return status == HTREE_OK;
}

static bool write_output(const nodes_args *args, const shape *mesh, char *error, size_t size) {
    whole_file out;
    if (args->output) {
        if (!whole_file_open(&out, args->output, error, size)) return false;
        const bool good = write_all(out.file, args, mesh, error, size);
        return whole_file_close(&out, good, error, size);
    }
    if (!write_all(stdout, args, mesh, error, size)) return false;
    const bool written = !ferror(stdout);
    if (fclose(stdout) == 0 && written) return true;
    snprintf(error, size, "standard output: %s", strerror(errno));
    return false;
}

int main(int argc, char **argv) {
    nodes_args args;
    shape mesh;
    char error[512];
    const args_result parsed = parse(&args, argc, argv);
    if (parsed != ARGS_RUN) return parsed == ARGS_DONE ? EXIT_SUCCESS : EXIT_USAGE;
    const bool read = args.mesh_path ? mesh_file_read(args.mesh_path, &mesh, error, sizeof error)
                                     : shape_make(&mesh, args.scene, args.triangles, 1) ||
                                           (snprintf(error, sizeof error, "out of memory"), false);
    const bool ok = read && write_output(&args, &mesh, error, sizeof error);
    if (!ok) fprintf(stderr, "%s: %s\n", program, error);
    shape_free(&mesh);
    return ok ? EXIT_SUCCESS : EXIT_INPUT;
}
