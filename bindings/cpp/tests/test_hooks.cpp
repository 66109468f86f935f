/* test_hooks.cpp: lambdas and objects that the library calls back, and options that reach it. */
#include "common.hpp"

#include <atomic>
#include <thread>

TEST_CASE("options say what a preset stands for, and reach the library") {
    CHECK(ht::options(ht::kind::h).kind() == ht::kind::h);
    CHECK(static_cast<int>(ht::options(ht::kind::fast).kind()) < HTREE_FAST);
    CHECK(static_cast<int>(ht::options(ht::kind::balanced).kind()) < HTREE_FAST);
    const ht::options how = ht::options(ht::kind::ah)
                                .threads(3)
                                .strict()
                                .any_planes()
                                .loose_planes()
                                .buckets(9)
                                .axes(3)
                                .costs(1, 2, 3, 4)
                                .cells_per_prim(0.25f)
                                .few_prims(32);
    const htree_options &c = how.raw();
    CHECK(c.kind == HTREE_AH);
    CHECK(c.threads == 3);
    CHECK(c.flags == (HTREE_STRICT | HTREE_ANY_PLANES | HTREE_LOOSE_PLANES));
    CHECK(c.buckets == 9);
    CHECK(c.axes == 3);
    CHECK(c.cost_skd == 1);
    CHECK(c.cost_bv2 == 2);
    CHECK(c.cost_bv6 == 3);
    CHECK(c.cost_intersect == 4);
    CHECK(c.cells_per_prim == 0.25f);
    CHECK(c.few_prims == 32);
    CHECK(ht::options(how).strict(false).raw().flags == (HTREE_ANY_PLANES | HTREE_LOOSE_PLANES));
    MUST(MUST(ht::tree::build(soup().mesh(), how)).check());
    CHECK(ht::query().raw().threads == 0);
    CHECK(ht::query().threads(5).raw().threads == 5);
}

TEST_CASE("measured costs are costs that a build takes") {
    ht::options how(ht::kind::h);
    MUST(how.calibrate());
    CHECK(how.raw().cost_skd == 1.0f);
    CHECK(how.raw().cost_intersect > 0);
    std::vector<ht::hit> hits(soup().rays.size());
    MUST(good_tree(how).intersect(soup().rays.data(), hits.size(), hits.data()));
    CHECK(same_bits(hits, soup().hits));
    ht::options bad;
    bad.raw().size = 0;
    CHECK_REFUSED(bad.calibrate(), ht::status::argument);
}

/* ---- Progress ------------------------------------------------------------------------------- */

struct watcher {
    int calls = 0;
    int stop_at = 0;
    double last = 0;
    bool fell = false, foreign = false;
    std::thread::id home = std::this_thread::get_id();

    bool operator()(double fraction) noexcept {
        fell = fell || fraction < last || fraction > 1;
        foreign = foreign || std::this_thread::get_id() != home;
        last = fraction;
        return ++calls == stop_at;
    }
};

TEST_CASE("progress rises on the caller's thread, and cancels where it says so") {
    watcher build, query, stop;
    const ht::tree tree = good_tree(ht::options(ht::kind::h).threads(1).progress(build));
    CHECK(build.calls > 3);
    CHECK_FALSE(build.fell);
    CHECK_FALSE(build.foreign);

    const std::vector<ht::ray> rays = many_rays(100);
    std::vector<ht::hit> hits(rays.size());
    std::vector<std::uint8_t> any(rays.size());
    MUST(tree.intersect(rays.data(), rays.size(), hits.data(),
                        ht::query().threads(1).progress(query)));
    CHECK(query.calls > 10);
    CHECK(query.last > 0.9);
    CHECK_FALSE(query.fell);
    CHECK_FALSE(query.foreign);

    stop.stop_at = 3;
    const ht::query stopped = ht::query().threads(1).progress(stop);
    CHECK_REFUSED(tree.intersect(rays.data(), rays.size(), hits.data(), stopped),
                  ht::status::cancelled);
    CHECK(stop.calls == 3);
    stop = watcher();
    stop.stop_at = 2;
    CHECK_REFUSED(tree.occluded(rays.data(), rays.size(), any.data(), stopped),
                  ht::status::cancelled);
    CHECK(stop.calls == 2);
}

/* ---- Tasks ---------------------------------------------------------------------------------- */

TEST_CASE("a tasks hook runs the parts of a batch, backwards or on its own threads") {
    std::atomic<int> batches{0}, tasks{0};
    const auto backwards = [&](std::uint32_t count, ht::task task) noexcept {
        ++batches;
        for (std::uint32_t i = count; i-- > 0; ++tasks) task(i);
    };
    const auto crew = [&](std::uint32_t count, ht::task task) noexcept {
        ++batches;
        std::thread odd([&] {
            for (std::uint32_t i = 1; i < count; i += 2, ++tasks) task(i);
        });
        for (std::uint32_t i = 0; i < count; i += 2, ++tasks) task(i);
        odd.join();
    };
    const std::vector<ht::ray> rays = many_rays(20);
    std::vector<ht::hit> alone(rays.size()), there(rays.size());
    MUST(good_tree().intersect(rays.data(), rays.size(), alone.data()));
    ht::options hooked[2];
    hooked[0].tasks(backwards);
    hooked[1].tasks(crew);
    for (const ht::options &how : hooked) {
        const ht::tree tree = good_tree(how);
        batches = tasks = 0;
        std::fill(there.begin(), there.end(), ht::hit());
        MUST(tree.intersect(rays.data(), rays.size(), there.data()));
        CHECK(batches == 1);
        CHECK(tasks > 4);
        CHECK(same_bits(alone, there));
    }
}

/* ---- Memory --------------------------------------------------------------------------------- */

struct miser {
    int left = 0;

    void *allocate(std::uint64_t bytes, std::uint64_t) noexcept {
        return left-- > 0 ? std::malloc(bytes) : nullptr;
    }
    void release(void *memory, std::uint64_t) noexcept {
        std::free(memory);
    }
};

TEST_CASE("an allocator that runs dry is status memory, at whichever call") {
    miser purse;
    int given = 0;
    for (;; ++given) {
        REQUIRE(given < 1000);
        purse.left = given;
        const ht::error why = ERROR_OF(
            ht::tree::build(soup().mesh(), ht::options(ht::kind::h).threads(1).allocator(purse)));
        if (why.code() == ht::status::ok) break;
        CHECK(why.code() == ht::status::memory);
    }
    CHECK(given > 2);
}

/* ---- Objects -------------------------------------------------------------------------------- */

struct sphere {
    float x, y, z, r;
};

/* The nearer root within [tmin, tmax]; rays of these tests start outside. */
static bool meet(const sphere &s, const ht::ray &ray, ht::hit &h) noexcept {
    const float o[3] = {ray.org[0] - s.x, ray.org[1] - s.y, ray.org[2] - s.z};
    const float a = ray.dir[0] * ray.dir[0] + ray.dir[1] * ray.dir[1] + ray.dir[2] * ray.dir[2];
    const float b = o[0] * ray.dir[0] + o[1] * ray.dir[1] + o[2] * ray.dir[2];
    const float c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - s.r * s.r;
    const float root = b * b - a * c;
    if (!(root >= 0)) return false;
    h.t = (-b - std::sqrt(root)) / a;
    h.u = 0.25f;
    h.v = 0.5f;
    return h.t >= ray.tmin && h.t <= ray.tmax;
}

TEST_CASE("objects are met by a lambda, alone and among triangles, on any thread") {
    std::vector<sphere> spheres;
    std::vector<ht::box> boxes;
    for (int i = 0; i < 64; ++i) {
        const sphere s = {static_cast<float>(i % 8), static_cast<float>(i / 8), 0, 0.375f};
        spheres.push_back(s);
        boxes.push_back(ht::box{{s.x - s.r, s.y - s.r, -s.r}, {s.x + s.r, s.y + s.r, s.r}});
    }
    std::atomic<int> calls{0};
    const auto ask = [&](std::uint32_t object, const ht::ray &ray, ht::hit &h) noexcept {
        ++calls;
        return meet(spheres[object], ray, h);
    };
    const float floor[9] = {-9, -9, -1, 99, -9, -1, -9, 99, -1};
    const ht::mesh mesh = ht::mesh(floor, 3).objects(boxes.data(), boxes.size(), ask);
    for (const std::string &name : the_file().kinds) {
        CAPTURE(name);
        const ht::kind kind = ht::kind_from_name(name.c_str());
        const ht::error refused = ERROR_OF(ht::tree::build(mesh, ht::options(kind)));
        if (refused.code() == ht::status::unsupported) continue; /* a kind of triangles only */
        const ht::tree tree = MUST(ht::tree::build(mesh, ht::options(kind)));
        CHECK(MUST(tree.stats()).objects == 64);
        std::vector<ht::ray> rays;
        for (int i = 0; i < 4096; ++i) {
            const sphere &s = spheres[static_cast<std::size_t>(i % 64)];
            const float aside = i < 2048 ? 0.0f : 0.46f; /* between four spheres */
            rays.push_back(ht::ray{{s.x + aside, s.y + aside, 5}, 0, {0, 0, -1}, 100});
        }
        std::vector<ht::hit> hits(rays.size());
        MUST(tree.intersect(rays.data(), rays.size(), hits.data(), ht::query().threads(2)));
        for (std::size_t i = 0; i < hits.size(); ++i) {
            const std::uint32_t prim = i < 2048 ? 1 + static_cast<std::uint32_t>(i % 64) : 0;
            CHECK(hits[i].prim == prim);
            CHECK(hits[i].t == (i < 2048 ? 4.625f : 6.0f));
        }
    }
    CHECK(calls > 2048);
}
