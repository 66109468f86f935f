/* ledger.c: every block carries a head with its size, so that releases can be checked. */
#include "ledger.h"

typedef struct block_head {
    uint64_t magic;
    uint64_t bytes;
    uint64_t room; /* bytes from the start of the raw block to the caller's memory */
} block_head;

static const uint64_t block_magic = 0x68747265652d6f6b;

void ledger_init(ledger *l) {
    memset(l, 0, sizeof *l);
    pthread_mutex_init(&l->lock, NULL);
}

void ledger_free(ledger *l) {
    pthread_mutex_destroy(&l->lock);
}

static bool enter(ledger *l, uint64_t bytes, uint64_t alignment) {
    pthread_mutex_lock(&l->lock);
    const uint64_t call = ++l->calls;
    const bool refuse =
        l->fail_at != 0 && (call == l->fail_at || (l->fail_for_good && call > l->fail_at));
    if (alignment == 0 || (alignment & (alignment - 1)) != 0 || bytes == 0) ++l->mistakes;
    if (!refuse) {
        ++l->live_blocks;
        l->live_bytes += bytes;
        if (l->live_bytes > l->peak_bytes) l->peak_bytes = l->live_bytes;
    }
    pthread_mutex_unlock(&l->lock);
    return !refuse;
}

static void leave(ledger *l, uint64_t bytes, bool right) {
    pthread_mutex_lock(&l->lock);
    l->mistakes += !right;
    --l->live_blocks;
    l->live_bytes -= bytes;
    pthread_mutex_unlock(&l->lock);
}

/* Fresh memory is filled with a pattern that no node, index or float survives. The block ends where
 * the caller's memory ends, and starts no more aligned than was asked for. */
static void *allocate(void *user, uint64_t bytes, uint64_t alignment) {
    ledger *const l = (ledger *)user;
    if (!enter(l, bytes, alignment)) return NULL;
    const uint64_t step = alignment < 32 ? 32 : alignment;
    void *raw = NULL;
    if (posix_memalign(&raw, (size_t)(2 * step), (size_t)(step + bytes)) != 0) abort();
    unsigned char *const memory = (unsigned char *)raw + step;
    memset(raw, 0xa5, (size_t)(step + bytes));
    const block_head head = {block_magic, bytes, step};
    memcpy(memory - sizeof head, &head, sizeof head);
    return memory;
}

static void release(void *user, void *memory, uint64_t bytes) {
    ledger *const l = (ledger *)user;
    block_head head;
    memcpy(&head, (unsigned char *)memory - sizeof head, sizeof head);
    const bool ours = head.magic == block_magic;
    leave(l, ours ? head.bytes : 0, ours && head.bytes == bytes);
    if (!ours) return;
    unsigned char *const raw = (unsigned char *)memory - head.room;
    memset(raw, 0xdd, (size_t)(head.room + head.bytes));
    free(raw);
}

htree_allocator ledger_allocator(ledger *l) {
    const htree_allocator hook = {allocate, release, l};
    return hook;
}

void ledger_fail(ledger *l, uint64_t call, bool for_good) {
    l->calls = 0;
    l->fail_at = call;
    l->fail_for_good = for_good;
}

void ledger_assert_balanced(const ledger *l) {
    assert_int_equal(l->mistakes, 0);
    assert_int_equal(l->live_blocks, 0);
    assert_int_equal(l->live_bytes, 0);
}

void ledger_fail_builds(const htree_mesh *mesh, const htree_options *options) {
    htree_options own = *options;
    htree_status status = HTREE_ERROR_MEMORY;
    ledger books;
    ledger_init(&books);
    own.allocator = ledger_allocator(&books);
    own.threads = 1;
    for (uint64_t k = 1; status != HTREE_OK; ++k) {
        htree *tree = NULL;
        ledger_fail(&books, k, true);
        status = htree_build(&tree, mesh, &own);
        assert_true(status == HTREE_ERROR_MEMORY || status == HTREE_OK);
        assert_true((tree != NULL) == (status == HTREE_OK));
        htree_free(tree);
    }
    ledger_assert_balanced(&books);
    ledger_free(&books);
}
