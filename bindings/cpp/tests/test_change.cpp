/* test_change.cpp: trees that rays build, compact and collapsed ones, and trees that are brought to
 * another mesh. */
#include "common.hpp"

#include <atomic>
#include <thread>

/* A wavy square of side x side cells: enough of it for a lazy tree to leave some to the rays. */
struct terrain {
    std::vector<float> xyz;
    std::vector<std::uint32_t> abc;

    explicit terrain(std::uint32_t side) {
        const std::uint32_t row = side + 1;
        for (std::uint32_t i = 0; i < row * row; ++i) {
            const float x = float(i % row) / float(side), y = float(i / row) / float(side);
            xyz.insert(xyz.end(), {x, y, 0.1f * std::sin(9 * x) * std::cos(7 * y)});
        }
        for (std::uint32_t i = 0; i < side * side; ++i) {
            const std::uint32_t a = i % side + i / side * row;
            abc.insert(abc.end(), {a, a + 1, a + row, a + 1, a + row + 1, a + row});
        }
    }
    void lift(float by) {
        for (std::size_t i = 0; i < xyz.size(); i += 3) xyz[i + 2] += by * xyz[i];
    }
    ht::mesh mesh() const {
        return ht::mesh(xyz.data(), xyz.size() / 3).indices(abc.data(), abc.size() / 3);
    }
};

static std::vector<ht::hit> hits_of(const ht::tree &tree) {
    std::vector<ht::ray> rays;
    for (int i = 0; i < 1600; ++i) {
        const float x = 1.2f * float(i % 40) / 40 - 0.1f, y = 1.2f * float(i / 40) / 40 - 0.1f;
        rays.push_back(ht::ray{{x, y, 2}, 0, {0.01f, 0.02f, -1}, INFINITY});
    }
    std::vector<ht::hit> hits(rays.size());
    MUST(tree.intersect(rays.data(), rays.size(), hits.data()));
    return hits;
}

static void check_answers_as(const ht::tree &tree, const ht::mesh &mesh) {
    const ht::tree other = MUST(ht::tree::build(mesh, ht::options(ht::kind::bvh_sah)));
    MUST(tree.check());
    CHECK(same_bits(hits_of(tree), hits_of(other)));
}

static bool same_nodes(const ht::tree &a, const ht::tree &b) {
    const ht::view va = MUST(a.view()), vb = MUST(b.view());
    return va.node_bytes == vb.node_bytes && va.leaf_bytes == vb.leaf_bytes &&
           std::memcmp(va.nodes, vb.nodes, va.node_bytes) == 0 &&
           std::memcmp(va.leaves, vb.leaves, va.leaf_bytes) == 0;
}

TEST_CASE("rays build a lazy tree, and complete builds the rest") {
    const terrain ground(60);
    ht::options lazily(ht::kind::wide), at_once(ht::kind::wide);
    ht::tree tree = MUST(ht::tree::build(ground.mesh(), lazily.lazy()));
    const ht::tree eager = MUST(ht::tree::build(ground.mesh(), at_once.morton()));
    const std::uint64_t subtrees = MUST(tree.stats()).subtrees;
    CHECK(subtrees > 10);
    CHECK(MUST(tree.stats()).subtrees_built == 0);
    CHECK(MUST(eager.stats()).subtrees == 0);
    MUST(tree.intersect(ht::ray{{0.3f, 0.4f, 2}, 0, {0, 0, -1}, INFINITY}));
    CHECK(MUST(tree.stats()).subtrees_built > 0);
    CHECK(MUST(tree.stats()).subtrees_built < subtrees);
    CHECK_REFUSED(tree.view(), ht::status::unsupported);
    check_answers_as(tree, ground.mesh());
    MUST(tree.complete());
    MUST(tree.complete());
    CHECK(MUST(tree.stats()).subtrees == 0);
    CHECK(same_nodes(tree, eager));
    check_answers_as(tree, ground.mesh());
}

TEST_CASE("a complete tree needs its mesh no more") {
    const terrain ground(60);
    ht::options how(ht::kind::wide);
    ht::tree tree;
    {
        const terrain copy = ground;
        tree = MUST(ht::tree::build(copy.mesh(), how.lazy()));
        MUST(tree.complete());
    }
    check_answers_as(tree, ground.mesh());
}

TEST_CASE("threads meet in a lazy tree") {
    const terrain ground(60);
    const std::vector<ht::hit> expected = hits_of(MUST(ht::tree::build(ground.mesh())));
    for (int round = 0; round < 10; ++round) {
        ht::options how(ht::kind::wide);
        const ht::tree tree = MUST(ht::tree::build(ground.mesh(), how.lazy()));
        std::atomic<int> wrong{0};
        std::vector<std::thread> threads;
        for (int i = 0; i < 4; ++i)
            threads.emplace_back([&] { wrong += same_bits(hits_of(tree), expected) ? 0 : 1; });
        for (std::thread &t : threads) t.join();
        CHECK(wrong == 0);
    }
}

TEST_CASE("compact trees answer alike in less than half of the memory") {
    terrain ground(60);
    ht::options how(ht::kind::wide);
    const ht::tree whole = MUST(ht::tree::build(ground.mesh(), how));
    ht::tree tree = MUST(ht::tree::build(ground.mesh(), how.compact()));
    CHECK(2 * MUST(tree.stats()).bytes < MUST(whole.stats()).bytes);
    CHECK_REFUSED(tree.view(), ht::status::unsupported);
    check_answers_as(tree, ground.mesh());
    check_answers_as(MUST(ht::tree::load(MUST(tree.save()))), ground.mesh());
    ground.lift(0.5f);
    CHECK(MUST(tree.update(ground.mesh(), ht::how::refit)) == 1);
    check_answers_as(tree, ground.mesh());
    CHECK_REFUSED(ht::tree::build(ground.mesh(), how.lazy()), ht::status::argument);
}

TEST_CASE("collapsed trees are wide, those of the preset best too") {
    const terrain ground(60);
    CHECK(ht::options(ht::kind::best).raw().flags == HTREE_COLLAPSE);
    for (const ht::kind kind : {ht::kind::bvh_median, ht::kind::ah, ht::kind::best}) {
        ht::options how(kind);
        const ht::tree tree = MUST(ht::tree::build(ground.mesh(), how.collapse()));
        CHECK(MUST(tree.stats()).kind == HTREE_WIDE);
        check_answers_as(tree, ground.mesh());
        const ht::tree plain = MUST(ht::tree::build(ground.mesh(), how.collapse(false)));
        CHECK(MUST(plain.stats()).kind == static_cast<htree_kind>(how.kind()));
    }
}

TEST_CASE("every kind answers as a new tree after updates") {
    for (const std::string &name : the_file().kinds) {
        CAPTURE(name);
        terrain ground(40);
        const ht::kind kind = ht::kind_from_name(name.c_str());
        ht::tree tree = MUST(ht::tree::build(ht::mesh(), ht::options(kind)));
        for (const ht::how way : {ht::how::rebuild, ht::how::refit, ht::how::rebuild}) {
            ground.lift(0.1f);
            const double quality = MUST(tree.update(ground.mesh(), way));
            CHECK(quality > 0.2);
            CHECK(quality < 20);
            if (way == ht::how::rebuild) CHECK(quality == 1);
            check_answers_as(tree, ground.mesh());
        }
    }
}

TEST_CASE("refitting is no rebuild") {
    terrain ground(40);
    ht::tree tree = MUST(ht::tree::build(ground.mesh()));
    ground.lift(0.5f);
    const ht::tree fresh = MUST(ht::tree::build(ground.mesh()));
    CHECK(MUST(tree.update(ground.mesh(), ht::how::refit)) != 1);
    CHECK_FALSE(same_nodes(tree, fresh));
    CHECK(MUST(tree.update(ground.mesh(), ht::how::rebuild)) == 1);
    CHECK(same_nodes(tree, fresh));
}

TEST_CASE("a mesh that is refused leaves the tree as it was") {
    const terrain ground(40);
    terrain bad = ground;
    bad.abc[7] = 1u << 30;
    ht::tree tree = MUST(ht::tree::build(ground.mesh()));
    for (const ht::how way : {ht::how::rebuild, ht::how::refit}) {
        CHECK_REFUSED(tree.update(bad.mesh(), way), ht::status::geometry);
        check_answers_as(tree, ground.mesh());
    }
    CHECK_REFUSED(tree.update(ground.mesh(), static_cast<ht::how>(3)), ht::status::argument);
}

TEST_CASE("objects are those of the last update") {
    const ht::box box = {{-1, -1, -1}, {1, 1, 1}};
    const ht::ray down = {{0, 0, 3}, 0, {0, 0, -1}, INFINITY};
    float t = 2;
    auto first = [](std::uint32_t, const ht::ray &, ht::hit &h) noexcept { return h.t = 2, true; };
    auto then = [&t](std::uint32_t, const ht::ray &, ht::hit &h) noexcept { return h.t = t, true; };
    ht::tree tree = MUST(ht::tree::build(ht::mesh().objects(&box, 1, first)));
    CHECK(MUST(tree.intersect(down)).t == 2);
    for (const ht::how way : {ht::how::rebuild, ht::how::refit}) {
        t += 0.25f;
        MUST(tree.update(ht::mesh().objects(&box, 1, then), way));
        CHECK(MUST(tree.intersect(down)).t == t);
    }
    MUST(tree.update(ht::mesh(), ht::how::rebuild));
    CHECK(MUST(tree.intersect(down)).prim == HTREE_NONE);
}
