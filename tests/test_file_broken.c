/* test_file_broken.c: what is no tree is not loaded: files cut short, with bytes changed, sealed anew or
 * not. What is loaded all the same is a tree. White-box: the header is written to. */
#include "ledger.h"
#include "saved.h"

#include "tree/file.h"

enum { RAYS = 24 };

static uint64_t loads, loaded;

/* A file to break, and what is needed to try what is left of it. */
typedef struct patient {
    seed_scene scene;
    htree_kind kind;
    saved whole, file; /* as it was saved, and broken */
    htree_load_options options;
    ledger books;
    htree_ray rays[RAYS];
} patient;

static void patient_begin(patient *p, htree_kind kind, int which, uint64_t triangles) {
    seed_scene_make(&p->scene, which, triangles);
    htree *const tree = seed_tree(&p->scene, kind);
    p->kind = kind;
    p->whole = saved_of(tree);
    p->file = saved_copy(p->whole.bytes, p->whole.size);
    ledger_init(&p->books);
    p->options = seed_load_options(&p->scene);
    p->options.allocator = ledger_allocator(&p->books);
    dice d = {17};
    rays_make_mixed(&p->scene.target, &d, p->rays, RAYS);
    htree_free(tree);
}

static void patient_end(patient *p) {
    ledger_assert_balanced(&p->books);
    ledger_free(&p->books);
    saved_free(&p->whole);
    saved_free(&p->file);
    seed_scene_free(&p->scene);
}

/* What was loaded answers, in steps that its nodes bound, and is saved as it was. */
static void use(const patient *p, const htree *tree) {
    htree_hit hits[RAYS];
    uint8_t any[RAYS];
    htree_counters counters[RAYS];
    htree_query query;
    assert_int_equal(htree_query_init(&query, sizeof query), HTREE_OK);
    query.threads = 1;
    query.counters = counters;
    const htree_stats stats = stats_of(tree);
    assert_int_equal(htree_intersect(tree, p->rays, RAYS, hits, NULL), HTREE_OK);
    assert_int_equal(htree_intersect(tree, p->rays, RAYS, hits, &query), HTREE_OK);
    assert_int_equal(htree_occluded(tree, p->rays, RAYS, any, NULL), HTREE_OK);
    for (int i = 0; i < RAYS; ++i) {
        assert_true(counters[i].traversal_steps <= 2 * stats.nodes + 1);
        assert_int_equal(any[i], hits[i].prim != HTREE_NONE);
    }
    saved again = saved_of(tree);
    assert_int_equal(again.size, p->file.size);
    assert_memory_equal(again.bytes, p->file.bytes, again.size);
    saved_free(&again);
}

/* Loads p->file: it is refused, or it is a tree. */
static bool attempt(patient *p) {
    htree *tree = NULL;
    p->books.peak_bytes = 0;
    p->options.flags = loads++ % 4 == 0 ? HTREE_BORROW : 0;
    const htree_status status = htree_load(&tree, p->file.bytes, p->file.size, &p->options);
    assert_true(p->books.peak_bytes <= 2 * p->file.size + 1024);
    if (status == HTREE_OK) {
        use(p, tree);
        ++loaded;
    } else {
        assert_true(status == HTREE_ERROR_CORRUPT || status == HTREE_ERROR_UNSUPPORTED);
        assert_null(tree);
    }
    htree_free(tree);
    return status == HTREE_OK;
}

static void for_each_patient(void (*treat)(patient *p, dice *d), uint64_t triangles) {
    dice d = {23};
    loads = loaded = 0;
    for (htree_kind kind = next_seed_kind(0); kind != 0; kind = next_seed_kind(kind)) {
        for (int which = 0; which < SEED_SCENES; ++which) {
            patient p;
            patient_begin(&p, kind, which, triangles);
            treat(&p, &d);
            patient_end(&p);
        }
    }
    say("loads: %llu, of which trees: %llu", (unsigned long long)loads, (unsigned long long)loaded);
    tally("broken files of trees", loads);
}

static void cut(patient *p, dice *d) {
    (void)d;
    const uint64_t size = p->file.size;
    for (uint64_t length = 0; length < size; ++length) {
        saved_free(&p->file); /* memory of just this length, for AddressSanitizer */
        p->file = saved_copy(p->whole.bytes, length);
        assert_false(attempt(p));
        if (length < sizeof(ht_file_header)) continue;
        memcpy(p->file.bytes + offsetof(ht_file_header, bytes), &length, sizeof length);
        if (length % 64 == 0) saved_seal(&p->file);
        assert_false(attempt(p));
    }
}

static void no_prefix_is_a_tree(void **state) {
    (void)state;
    for_each_patient(cut, 12);
}

/* Byte i with its k-th change: by one of its bits, by all bits, or at random. */
enum { CHANGES = 11 };
static void change_byte(patient *p, dice *d, uint64_t i, uint32_t k) {
    const uint32_t bits = k < 8 ? 1u << k : k == 8 ? 255 : 1 + dice_below(d, 254);
    p->file.bytes[i] = (char)((uint32_t)(unsigned char)p->whole.bytes[i] ^ bits);
}

/* Slow builds make some of the changes. */
static uint32_t first_change(void) {
    return scaled(100) < 100 ? 7 : 0;
}

static void flip(patient *p, dice *d) {
    for (uint64_t i = 0; i < p->file.size; ++i) {
        for (uint32_t k = first_change(); k < CHANGES; ++k) {
            change_byte(p, d, i, k);
            assert_false(attempt(p));
        }
        p->file.bytes[i] = p->whole.bytes[i];
    }
    assert_true(attempt(p));
}

static void the_checksum_finds_every_changed_byte(void **state) {
    (void)state;
    for_each_patient(flip, 12);
}

/* The seal is whole. */
static void flip_and_seal(patient *p, dice *d) {
    for (uint64_t i = 0; i < p->file.size; ++i) {
        for (uint32_t k = first_change(); k < CHANGES; ++k) {
            change_byte(p, d, i, k);
            saved_seal(&p->file);
            (void)attempt(p);
        }
        memcpy(p->file.bytes, p->whole.bytes, p->whole.size);
    }
}

static void sealed_flips_do_no_harm(void **state) {
    (void)state;
    for_each_patient(flip_and_seal, scaled(100) < 100 ? 2 : 12);
    assert_true(loaded > 0);
}

/* One to four words at once: numbers at the ends of ranges, other words of the file, steps. */
static void change_words(patient *p, dice *d) {
    static const uint32_t special[] = {0,          1,          2,          0x7f800000, 0xff800000,
                                       0x7fc00000, 0x7f7fffff, 0x80000000, 0xffffffff, 0xfffffffe,
                                       0x00000001, 0x3f800000, 0x5d800000, 0x5d800001, 0x10000000};
    const uint32_t words = (uint32_t)(p->file.size / 4);
    for (uint64_t i = 0; i < scaled(10000); ++i) {
        for (uint32_t n = 1 + dice_below(d, 4); n > 0; --n) {
            const uint32_t at = dice_below(d, words), from = dice_below(d, words);
            uint32_t word;
            memcpy(&word, p->file.bytes + 4 * (uint64_t)at, 4);
            switch (dice_below(d, 4)) {
            case 0: word = special[dice_below(d, COUNT_OF(special))]; break;
            case 1: memcpy(&word, p->file.bytes + 4 * (uint64_t)from, 4); break;
            case 2: word += dice_below(d, 2) ? 1 : UINT32_MAX; break;
            default: word = dice_u32(d) >> dice_below(d, 32); break;
            }
            memcpy(p->file.bytes + 4 * (uint64_t)at, &word, 4);
        }
        saved_seal(&p->file);
        (void)attempt(p);
        memcpy(p->file.bytes, p->whole.bytes, p->whole.size);
    }
}

static void sealed_words_do_no_harm(void **state) {
    (void)state;
    for_each_patient(change_words, 30);
}

/* ---- Findings, and what chance does not find ------------------------------------------------ */

static void load_as(patient *p, htree_status status) {
    htree *tree = NULL;
    saved_seal(&p->file);
    assert_int_equal(htree_load(&tree, p->file.bytes, p->file.size, &p->options), status);
    htree_free(tree);
    memcpy(p->file.bytes, p->whole.bytes, p->whole.size);
}

static void set_word(patient *p, uint64_t offset, uint32_t word) {
    memcpy(p->file.bytes + offset, &word, sizeof word);
}

/* Counts of any size are refused before a byte is taken for them. Sixteen more of anything take more
 * room than there is between arrays. */
static void counts_are_not_believed(void **state) {
    patient p;
    (void)state;
    patient_begin(&p, HTREE_KD, SEED_KNOT, 12);
    const uint64_t calls = p.books.calls;
    for (uint64_t field = offsetof(ht_file_header, triangle_count);
         field <= offsetof(ht_file_header, ref_count); field += 4) {
        for (uint32_t bit = 4; bit < 32; ++bit) {
            uint32_t count;
            memcpy(&count, p.file.bytes + field, sizeof count);
            set_word(&p, field, count ^ (1u << bit));
            load_as(&p, HTREE_ERROR_CORRUPT);
        }
    }
    assert_int_equal(p.books.calls, calls);
    patient_end(&p);
}

static void other_versions_and_byte_orders_are_told_apart(void **state) {
    patient p;
    (void)state;
    patient_begin(&p, HTREE_H, SEED_KNOT, 12);
    set_word(&p, offsetof(ht_file_header, format), HT_FILE_FORMAT + 1);
    load_as(&p, HTREE_ERROR_UNSUPPORTED);
    set_word(&p, offsetof(ht_file_header, order), 0x04030201);
    load_as(&p, HTREE_ERROR_UNSUPPORTED);
    set_word(&p, 0, 0);
    load_as(&p, HTREE_ERROR_CORRUPT);
    patient_end(&p);
}

/* htree_update would build with them. */
static void options_that_there_are_not_are_refused(void **state) {
    static const struct {
        uint64_t offset;
        uint32_t words[5]; /* up to a zero */
        htree_status status;
    } cases[] = {
        {offsetof(ht_file_header, built_as),
         {HTREE_UG, HTREE_BVH_SAH, HTREE_FAST, 9, UINT32_MAX},
         HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, flags),
         {HTREE_LAZY | HTREE_COMPACT, 128, UINT32_MAX},
         HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, flags), {1, 2, 4, HTREE_MORTON, HTREE_LAZY}, HTREE_OK},
        {offsetof(ht_file_header, buckets), {1, 65, UINT32_MAX}, HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, buckets), {2, 64}, HTREE_OK},
        {offsetof(ht_file_header, axes), {2, 4}, HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, few_prims), {(1 << 20) + 1, UINT32_MAX}, HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, cells_per_prim),
         {1, 0x42800001, 0x7f800000, 0x7fc00000, 0xbf800000},
         HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, cost[3]), {0x7fc00000, 0xbf800000}, HTREE_ERROR_CORRUPT},
        {offsetof(ht_file_header, spare[4]), {1}, HTREE_ERROR_CORRUPT},
    };
    patient p;
    (void)state;
    patient_begin(&p, HTREE_WIDE, SEED_KNOT, 12);
    for (uint32_t i = 0; i < COUNT_OF(cases); ++i) {
        for (uint32_t k = 0; k < COUNT_OF(cases[i].words) && cases[i].words[k] != 0; ++k) {
            set_word(&p, cases[i].offset, cases[i].words[k]);
            load_as(&p, cases[i].status);
        }
    }
    for (uint64_t field = offsetof(ht_file_header, built_as);
         field < offsetof(ht_file_header, spare); field += 4) {
        if (field == offsetof(ht_file_header, flags)) continue;
        set_word(&p, field, 0);
        load_as(&p, HTREE_ERROR_CORRUPT);
    }
    patient_end(&p);
}

/* The slots of a bounding node are counted by the planes that a walk knows. */
static void sets_of_unknown_planes_are_refused(void **state) {
    patient p;
    (void)state;
    patient_begin(&p, HTREE_H, SEED_KNOT, 200);
    ht_file_header header;
    memcpy(&header, p.whole.bytes, sizeof header);
    const ht_file_plan plan = ht_file_plan_of(&header);
    uint32_t nodes = 0;
    for (uint32_t i = 0; i < header.node_slots; ++i) {
        const uint64_t at = plan.offset[2] + i * sizeof(ht_h_node);
        ht_h_node node;
        memcpy(&node, p.whole.bytes + at, sizeof node);
        if ((node.tag & HT_H_TYPE) != HT_H_BVO) continue;
        set_word(&p, at + offsetof(ht_h_node, tag), node.tag | 64u << HT_H_TAG_BITS);
        load_as(&p, HTREE_ERROR_CORRUPT);
        ++nodes;
    }
    assert_true(nodes > 0);
    patient_end(&p);
}

static void grids_of_other_cells_are_refused(void **state) {
    patient p;
    (void)state;
    patient_begin(&p, HTREE_UG, SEED_KNOT, 200);
    for (uint32_t axis = 0; axis < 3; ++axis) {
        const uint64_t at = offsetof(ht_file_header, grid.cells) + axis * sizeof(uint32_t);
        uint32_t cells;
        memcpy(&cells, p.whole.bytes + at, sizeof cells);
        for (int k = 0; k < 4; ++k) {
            const uint32_t other[] = {0, 1, cells - 1, cells + 1};
            if (other[k] == cells) continue;
            set_word(&p, at, other[k]);
            load_as(&p, HTREE_ERROR_CORRUPT);
        }
    }
    patient_end(&p);
}

/* A box that is inside out by less than the pad of a ray is met, and then an idle lane is a child. */
static void idle_lanes_that_rays_could_meet_are_refused(void **state) {
    patient p;
    (void)state;
    patient_begin(&p, HTREE_WIDE, SEED_TRIANGLE, 1);
    ht_file_header header;
    memcpy(&header, p.whole.bytes, sizeof header);
    const uint64_t at = ht_file_plan_of(&header).offset[2];
    ht_wide_node node;
    memcpy(&node, p.whole.bytes + at, sizeof node);
    uint32_t lane = 0;
    while (node.child[lane] != HT_WIDE_NONE) ++lane;
    assert_true(lane < HT_LANES);
    for (int k = 0; k < 3; ++k) {
        node.hi[k][lane] = 0.25f;
        node.lo[k][lane] = nudged(0.25f, 1);
    }
    memcpy(p.file.bytes + at, &node, sizeof node);
    load_as(&p, HTREE_ERROR_CORRUPT);
    patient_end(&p);
}

/* A walk of a wide tree pushes all children of a node before it takes one. */
static void stacks_larger_than_those_of_walks_are_refused(void **state) {
    (void)state;
    for (htree_kind kind = next_seed_kind(0); kind != 0; kind = next_seed_kind(kind)) {
        patient p;
        patient_begin(&p, kind, SEED_KNOT, 12);
        const uint32_t most = kind >= HTREE_WIDE ? HT_WIDE_STACK - 1 : HT_MAX_DEPTH;
        set_word(&p, offsetof(ht_file_header, stack), most);
        load_as(&p, HTREE_OK);
        set_word(&p, offsetof(ht_file_header, stack), most + 1);
        load_as(&p, HTREE_ERROR_CORRUPT);
        patient_end(&p);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_prefix_is_a_tree),
        cmocka_unit_test(the_checksum_finds_every_changed_byte),
        cmocka_unit_test(sealed_flips_do_no_harm),
        cmocka_unit_test(sealed_words_do_no_harm),
        cmocka_unit_test(counts_are_not_believed),
        cmocka_unit_test(other_versions_and_byte_orders_are_told_apart),
        cmocka_unit_test(options_that_there_are_not_are_refused),
        cmocka_unit_test(sets_of_unknown_planes_are_refused),
        cmocka_unit_test(grids_of_other_cells_are_refused),
        cmocka_unit_test(idle_lanes_that_rays_could_meet_are_refused),
        cmocka_unit_test(stacks_larger_than_those_of_walks_are_refused),
    };
    return cmocka_run_group_tests_name("file-broken", tests, NULL, NULL);
}
