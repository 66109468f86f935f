/* test_life.cpp: who owns what, and when it ends. */
#include "common.hpp"

#include <atomic>
#include <cstdio>
#include <memory>
#include <thread>
#include <type_traits>

static_assert(!std::is_copy_constructible<ht::tree>::value, "a tree has one owner");
static_assert(!std::is_copy_assignable<ht::tree>::value, "a tree has one owner");
static_assert(std::is_nothrow_move_constructible<ht::tree>::value, "moves cannot fail");
static_assert(std::is_nothrow_move_assignable<ht::tree>::value, "moves cannot fail");
static_assert(std::is_nothrow_default_constructible<ht::tree>::value,
              "an empty tree costs nothing");
static_assert(sizeof(ht::tree) == sizeof(void *), "a tree is its handle");
static_assert(std::is_nothrow_copy_constructible<ht::error>::value, "errors are thrown");
static_assert(sizeof(ht::ray) == 32 && sizeof(ht::hit) == 16, "the same bytes as in C");
#ifdef HTREE_HPP_STATUS
static_assert(noexcept(std::declval<ht::tree &>().check()), "statuses do not throw");
#endif

/* Memory that is counted: what lives is what has not been released. */
struct ledger {
    std::atomic<std::int64_t> live{0}, calls{0};

    void *allocate(std::uint64_t bytes, std::uint64_t alignment) noexcept {
        void *memory = nullptr;
        const std::size_t align = alignment < sizeof(void *) ? sizeof(void *) : alignment;
        if (posix_memalign(&memory, align, bytes) != 0) return nullptr;
        ++live;
        ++calls;
        return memory;
    }
    void release(void *memory, std::uint64_t) noexcept {
        if (memory != nullptr) --live;
        std::free(memory);
    }
};

/* 0 where a sanitizer keeps freed memory back: there the ledger alone decides. */
static long resident_pages() {
#ifdef __SANITIZE_ADDRESS__
    return 0;
#endif
    long all = 0, resident = 0;
    std::FILE *const f = std::fopen("/proc/self/statm", "r");
    if (f == nullptr) return 0;
    if (std::fscanf(f, "%ld %ld", &all, &resident) != 2) resident = 0;
    std::fclose(f);
    return resident;
}

static void check_closed(ht::tree &tree) {
    ht::hit h;
    std::uint8_t any;
    const ht::ray &ray = soup().rays[0];
    CHECK_FALSE(tree);
    CHECK(tree.get() == nullptr);
    CHECK_REFUSED(tree.intersect(ray), ht::status::argument);
    CHECK_REFUSED(tree.intersect(&ray, 1, &h), ht::status::argument);
    CHECK_REFUSED(tree.intersect(&ray, 1, &h, ht::query()), ht::status::argument);
    CHECK_REFUSED(tree.occluded(ray), ht::status::argument);
    CHECK_REFUSED(tree.occluded(&ray, 1, &any), ht::status::argument);
    CHECK_REFUSED(tree.occluded(&ray, 1, &any, ht::query()), ht::status::argument);
    CHECK_REFUSED(tree.bounds(), ht::status::argument);
    CHECK_REFUSED(tree.stats(), ht::status::argument);
    CHECK_REFUSED(tree.view(), ht::status::argument);
    CHECK_REFUSED(tree.check(), ht::status::argument);
    CHECK_REFUSED(tree.complete(), ht::status::argument);
    CHECK_REFUSED(tree.update(soup().mesh(), ht::how::refit), ht::status::argument);
}

TEST_CASE("an empty, a closed and a twice closed tree refuse every call") {
    ht::tree empty;
    check_closed(empty);
    ht::tree tree = good_tree();
    CHECK(tree);
    tree.close();
    check_closed(tree);
    tree.close();
    check_closed(tree);
}

TEST_CASE("moves hand the tree over and leave an empty one") {
    ledger books;
    {
        ht::tree a = good_tree(ht::options().allocator(books));
        const std::int64_t blocks = books.live;
        CHECK(blocks > 0);
        ht::tree b = std::move(a);
        check_closed(a);
        MUST(b.check());
        CHECK(books.live == blocks);

        ht::tree other = good_tree(ht::options().allocator(books));
        other = std::move(b); /* frees what it held */
        CHECK(books.live == blocks);
        ht::tree &self = other;
        other = std::move(self);
        MUST(other.check());

        ht::tree adopted(other.release());
        check_closed(other);
        MUST(adopted.check());
        a = std::move(adopted); /* an emptied tree can be filled again */
        MUST(a.check());
    }
    CHECK(books.live == 0);
}

TEST_CASE("the mesh may go as soon as the tree is built, the last tree first or last") {
    std::vector<ht::tree> trees;
    for (int i = 0; i < 8; ++i) {
        const scene copy = soup();
        trees.push_back(MUST(ht::tree::build(copy.mesh())));
    }
    for (const std::size_t at : {7u, 0u, 3u, 2u, 0u}) {
        trees.erase(trees.begin() + static_cast<std::ptrdiff_t>(at));
        for (const ht::tree &tree : trees) {
            const ht::hit h = MUST(tree.intersect(soup().rays[1]));
            CHECK(std::memcmp(&h, &soup().hits[1], sizeof h) == 0);
        }
    }
}

TEST_CASE("a failed build leaves nothing behind") {
    ledger books;
    const auto stop = [](double) noexcept { return true; };
    ht::options how;
    how.allocator(books).progress(stop);
    for (int i = 0; i < 100; ++i)
        CHECK_REFUSED(ht::tree::build(soup().mesh(), how), ht::status::cancelled);
    CHECK(books.calls > 0);
    CHECK(books.live == 0);
}

TEST_CASE("a hundred thousand trees come and go without growth") {
    const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    ledger books;
    const ht::options how = ht::options().threads(1).allocator(books);
    long before = 0;
    for (int i = 0; i < 100000; ++i) {
        if (i == 10000) before = resident_pages();
        ht::tree tree = MUST(ht::tree::build(ht::mesh(xyz, 3), how));
        if (i % 2 != 0) tree.close();
    }
    CHECK(books.live == 0);
    CHECK(books.calls >= 100000);
    CHECK(resident_pages() - before < 1024); /* 4 MiB */
}

TEST_CASE("a view shows the arrays of the tree that owns them") {
    for (const std::string &name : the_file().kinds) {
        CAPTURE(name);
        const ht::tree tree = good_tree(ht::options(ht::kind_from_name(name.c_str())));
        const ht::view view = MUST(tree.view());
        CHECK(name == ht::kind_name(static_cast<ht::kind>(view.kind)));
        CHECK(view.prims == soup().triangles);
        CHECK(view.triangle_count == soup().triangles);
        CHECK(view.object_count == 0);
        CHECK(std::memcmp(&view.bounds, &soup().bounds, sizeof view.bounds) == 0);
        CHECK(view.node_bytes > 0);
        CHECK((view.triangles == nullptr) == (name == "wide"));
        if (view.triangles == nullptr) continue; /* its leaves hold the corners */
        for (std::size_t corner = 0; corner < soup().abc.size(); ++corner)
            CHECK(std::memcmp(view.triangles + 3 * corner, &soup().xyz[3 * soup().abc[corner]],
                              3 * sizeof(float)) == 0);
    }
}

TEST_CASE("many threads ask one tree") {
    const ht::tree tree = good_tree();
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([&tree, &wrong, i] {
            std::vector<ht::hit> hits(soup().rays.size());
            for (int turn = 0; turn < 50; ++turn) {
                const ht::query how = ht::query().threads(i % 2 == 0 ? 1 : 0);
                MUST(tree.intersect(soup().rays.data(), hits.size(), hits.data(), how));
                if (!same_bits(hits, soup().hits)) ++wrong;
            }
        });
    }
    for (std::thread &t : threads) t.join();
    CHECK(wrong == 0);
}

/* Each thread holds a share; whoever lets go last closes the tree. */
TEST_CASE("a shared tree outlives its maker's interest while queries run") {
    ledger books;
    std::atomic<int> wrong{0}, started{0};
    for (int round = 0; round < 20; ++round) {
        std::shared_ptr<const ht::tree> shared =
            std::make_shared<const ht::tree>(good_tree(ht::options().allocator(books)));
        std::vector<std::thread> threads;
        started = 0;
        for (int i = 0; i < 3; ++i) {
            threads.emplace_back([shared, &wrong, &started] {
                const std::vector<ht::ray> rays = many_rays(5);
                std::vector<ht::hit> hits(rays.size());
                ++started;
                for (int turn = 0; turn < 5; ++turn)
                    MUST(shared->intersect(rays.data(), rays.size(), hits.data()));
                hits.resize(soup().hits.size());
                if (!same_bits(hits, soup().hits)) ++wrong;
            });
        }
        while (started < 3) std::this_thread::yield();
        shared.reset();
        for (std::thread &t : threads) t.join();
    }
    CHECK(wrong == 0);
    CHECK(books.live == 0);
}
