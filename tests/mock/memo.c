/* memo.c: the CPU's side of the proofs that libhtree_cl makes, remembered: it is most of the
 * time of a test that opens a device ten thousand times. The linker lets htree_intersect come
 * here. */
#include "mock_cl.h"

#include "htree.h"

htree_status __real_htree_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                                    htree_hit *hits, const htree_query *query);
htree_status __wrap_htree_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                                    htree_hit *hits, const htree_query *query);

htree_status __wrap_htree_intersect(const htree *tree, const htree_ray *rays, uint64_t count,
                                    htree_hit *hits, const htree_query *query) {
    htree_view view;
    view.size = sizeof view;
    if (query || !rays || !hits || htree_get_view(tree, &view) != HTREE_OK)
        return __real_htree_intersect(tree, rays, count, hits, query);
    uint64_t question = mock_hash((uint64_t)view.kind, &view.bounds, sizeof view.bounds);
    question = mock_hash(question, view.nodes, (size_t)view.node_bytes);
    question = mock_hash(question, view.leaves, (size_t)view.leaf_bytes);
    if (view.triangles)
        question = mock_hash(question, view.triangles, 36 * (size_t)view.triangle_count);
    question = mock_hash(question, rays, (size_t)count * sizeof *rays);
    if (mock_remember(question, hits, (size_t)count * sizeof *hits)) return HTREE_OK;
    const htree_status status = __real_htree_intersect(tree, rays, count, hits, query);
    if (status == HTREE_OK) mock_learn(question, hits, (size_t)count * sizeof *hits);
    return status;
}
