#include "build_tree.h"

#include "progress.h"

htree_status build_tree(htree **tree, const shape *s, htree_kind kind, uint32_t threads,
                        bool quiet) {
    const htree_mesh mesh = shape_mesh(s);
    htree_options options;
    htree_status status = htree_options_init(&options, sizeof options, kind);
    if (status != HTREE_OK) return status;
    progress bar = progress_start("build", quiet);
    options.threads = threads;
    options.progress.report = progress_report;
    options.progress.user = &bar;
    status = htree_build(tree, &mesh, &options);
    progress_end(&bar);
    return status;
}
