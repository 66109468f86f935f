/* test_conformance.cpp: the answers of every scene, kind and way to ask, bit for bit. */
#include "common.hpp"

#include <algorithm>

static ht::kind kind_of(const std::string &name) {
    return ht::kind_from_name(name.c_str());
}

static void check_facts(const scene &s, const ht::tree &tree, ht::kind kind) {
    const ht::box bounds = MUST(tree.bounds());
    const ht::stats stats = MUST(tree.stats());
    CHECK(std::memcmp(&bounds, &s.bounds, sizeof bounds) == 0);
    CHECK(static_cast<ht::kind>(stats.kind) == kind);
    CHECK(stats.triangles == s.triangles);
    CHECK(stats.objects == s.objects);
    CHECK(stats.invalid == s.invalid);
    CHECK(stats.degenerate == s.degenerate);
    MUST(tree.check());
}

static void check_answers(const scene &s, const ht::tree &tree, std::uint32_t threads) {
    const ht::query how = ht::query().threads(threads);
    std::vector<ht::hit> hits(s.rays.size());
    std::vector<std::uint8_t> occluded(s.rays.size(), 7);
    MUST(tree.intersect(s.rays.data(), s.rays.size(), hits.data()));
    CHECK(same_bits(hits, s.hits));
    std::fill(hits.begin(), hits.end(), ht::hit());
    MUST(tree.intersect(s.rays.data(), s.rays.size(), hits.data(), how));
    CHECK(same_bits(hits, s.hits));
    MUST(tree.occluded(s.rays.data(), s.rays.size(), occluded.data()));
    CHECK(occluded == s.occluded);
    std::fill(occluded.begin(), occluded.end(), std::uint8_t(7));
    MUST(tree.occluded(s.rays.data(), s.rays.size(), occluded.data(), how));
    CHECK(occluded == s.occluded);
}

TEST_CASE("every scene, kind and number of threads gives the file's answers") {
    CHECK(the_file().scenes.size() >= 6);
    for (const scene &s : the_file().scenes) {
        for (const std::string &name : the_file().kinds) {
            for (const std::uint32_t threads : {1u, 0u}) {
                CAPTURE(s.name);
                CAPTURE(name);
                CAPTURE(threads);
                const ht::kind kind = kind_of(name);
                const ht::tree tree =
                    MUST(ht::tree::build(s.mesh(), ht::options(kind).threads(threads)));
                check_facts(s, tree, kind);
                check_answers(s, tree, threads);
            }
        }
    }
}

TEST_CASE("lazy trees and complete ones give the file's answers") {
    for (const scene &s : the_file().scenes) {
        CAPTURE(s.name);
        ht::tree tree = MUST(ht::tree::build(s.mesh(), ht::options(ht::kind::wide).lazy()));
        check_answers(s, tree, 0);
        MUST(tree.complete());
        check_facts(s, tree, ht::kind::wide);
        check_answers(s, tree, 0);
    }
}

TEST_CASE("a tree that goes from scene to scene gives the file's answers") {
    for (const std::string &name : the_file().kinds) {
        CAPTURE(name);
        ht::tree tree = good_tree(ht::options(kind_of(name)));
        for (const scene &s : the_file().scenes) {
            CAPTURE(s.name);
            for (const ht::how way : {ht::how::rebuild, ht::how::refit}) {
                MUST(tree.update(s.mesh(), way));
                check_facts(s, tree, kind_of(name));
                check_answers(s, tree, 0);
            }
        }
    }
}

TEST_CASE("a ray alone is answered as in a batch") {
    for (const scene &s : the_file().scenes) {
        const ht::tree tree = MUST(ht::tree::build(s.mesh()));
        for (std::size_t i = 0; i < s.rays.size(); ++i) {
            const ht::hit h = MUST(tree.intersect(s.rays[i]));
            CHECK(std::memcmp(&h, &s.hits[i], sizeof h) == 0);
            CHECK(MUST(tree.occluded(s.rays[i])) == (s.occluded[i] != 0));
        }
    }
}

TEST_CASE("vertices may be structs, and positions any stride apart") {
    struct vertex {
        float x, y, z, nx, ny;
    };
    const scene &s = soup();
    std::vector<vertex> vertices;
    for (std::size_t i = 0; i + 2 < s.xyz.size(); i += 3)
        vertices.push_back(vertex{s.xyz[i], s.xyz[i + 1], s.xyz[i + 2], -1, 1e30f});
    ht::mesh mesh(vertices.data(), vertices.size());
    check_answers(
        s, MUST(ht::tree::build(mesh.indices(s.abc.data(), s.abc.size() / 3), ht::options())), 1);
    ht::mesh same(&vertices[0].x, vertices.size(), sizeof(vertex));
    check_answers(
        s, MUST(ht::tree::build(same.indices(s.abc.data(), s.abc.size() / 3), ht::options())), 1);
}

TEST_CASE("counters are written for every ray and change no hit") {
    const ht::tree tree = good_tree();
    const scene &s = soup();
    std::vector<ht::counters> costs(s.rays.size(), ht::counters{7, 7, 7, 7});
    std::vector<ht::hit> hits(s.rays.size());
    const ht::query how = ht::query().counters(costs.data(), costs.size()).threads(1);
    MUST(tree.intersect(s.rays.data(), s.rays.size(), hits.data(), how));
    CHECK(same_bits(hits, s.hits));
    std::uint64_t steps = 0, tests = 0;
    for (const ht::counters &c : costs) {
        CHECK(c.reserved == 0);
        CHECK(c.leaf_steps <= c.traversal_steps);
        steps += c.traversal_steps;
        tests += c.intersections;
    }
    CHECK(steps > s.rays.size());
    CHECK(tests > 100);
    CHECK_REFUSED(tree.intersect(s.rays.data(), s.rays.size() + 1, hits.data(), how),
                  ht::status::argument);
}

#ifdef __cpp_lib_span
TEST_CASE("spans: the same answers, and sizes that do not fit are refused") {
    const scene &s = soup();
    const ht::tree tree = MUST(ht::tree::build(ht::mesh(s.xyz).indices(s.abc), ht::options()));
    std::vector<ht::hit> hits(s.rays.size());
    std::vector<std::uint8_t> occluded(s.rays.size());
    std::vector<ht::counters> costs(s.rays.size());
    MUST(tree.intersect(s.rays, hits));
    CHECK(same_bits(hits, s.hits));
    MUST(tree.intersect(s.rays, hits, ht::query().counters(costs)));
    MUST(tree.occluded(s.rays, occluded));
    CHECK(occluded == s.occluded);
    MUST(tree.occluded(s.rays, occluded, ht::query().threads(2)));
    const std::span<ht::hit> short_hits(hits.data(), hits.size() - 1);
    const std::span<std::uint8_t> short_answers(occluded.data(), 3);
    costs.pop_back();
    CHECK_REFUSED(tree.intersect(s.rays, short_hits), ht::status::argument);
    CHECK_REFUSED(tree.intersect(s.rays, short_hits, ht::query()), ht::status::argument);
    CHECK_REFUSED(tree.occluded(s.rays, short_answers), ht::status::argument);
    CHECK_REFUSED(tree.occluded(s.rays, short_answers, ht::query()), ht::status::argument);
    CHECK_REFUSED(tree.intersect(s.rays, hits, ht::query().counters(costs)), ht::status::argument);
}
#endif
