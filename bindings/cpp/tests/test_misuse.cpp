/* test_misuse.cpp: statuses, names, versions, and every misuse that the conformance file lists. */
#include "common.hpp"

#include <functional>

static const float nan_value = std::numeric_limits<float>::quiet_NaN();

/* The status in a word of the conformance file, by way of the type's own names. */
static const std::map<std::string, ht::status> words = {
    {"OK", ht::status::ok},
    {"ARGUMENT", ht::status::argument},
    {"MEMORY", ht::status::memory},
    {"LIMIT", ht::status::limit},
    {"GEOMETRY", ht::status::geometry},
    {"CANCELLED", ht::status::cancelled},
    {"UNSUPPORTED", ht::status::unsupported},
    {"CORRUPT", ht::status::corrupt},
    {"NO_DEVICE", ht::status::no_device},
    {"DEVICE", ht::status::device},
    {"DEVICE_LOST", ht::status::device_lost},
    {"KERNEL", ht::status::kernel},
};

TEST_CASE("statuses have the file's numbers and names") {
    CHECK(words.size() == the_file().statuses.size());
    for (const auto &s : the_file().statuses) {
        CAPTURE(s.first);
        REQUIRE(words.count(s.first) == 1);
        CHECK(static_cast<int>(words.at(s.first)) == s.second);
    }
    for (const auto &s : the_file().status_names)
        CHECK(s.second == ht::status_name(static_cast<ht::status>(s.first)));
    CHECK(std::string(ht::error(ht::status::memory, "").name()) == "out of memory");
}

TEST_CASE("kinds go to names and back") {
    for (const std::string &name : the_file().kinds)
        CHECK(name == ht::kind_name(ht::kind_from_name(name.c_str())));
    CHECK(ht::kind_from_name("bvh-sah") == ht::kind::bvh_sah);
    CHECK(ht::kind_from_name("no such kind") == ht::kind::none);
    CHECK(ht::kind_from_name(nullptr) == ht::kind::none);
    CHECK(ht::kind_name(ht::kind::none) == nullptr);
}

TEST_CASE("versions: the header's, the library's, and which go together") {
    const std::uint32_t v = ht::version();
    const std::string text = std::to_string(v / 10000) + "." + std::to_string(v / 100 % 100) + "." +
                             std::to_string(v % 100);
    CHECK(text == the_file().library);
    CHECK(ht::is_compatible(v, ht::header_version()));
    CHECK(ht::is_compatible(107, 100));
    CHECK_FALSE(ht::is_compatible(200, 100));
    CHECK_FALSE(ht::is_compatible(10100, 100));
    CHECK(ht::is_compatible(10900, 10100));
    CHECK_FALSE(ht::is_compatible(20100, 10100));
}

/* ---- Misuse --------------------------------------------------------------------------------- */

static const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const std::uint32_t abc[3] = {0, 1, 2};

static ht::mesh one() {
    return ht::mesh(xyz, 3).indices(abc, 1);
}

static ht::status build(const ht::mesh &mesh, const ht::options &how) {
    const ht::error why = ERROR_OF(ht::tree::build(mesh, how));
    CHECK(std::strlen(why.what()) > 5);
    return why.code();
}

static ht::status build(const ht::options &how) {
    return build(one(), how);
}

static ht::status raw(htree_status s) {
    return static_cast<ht::status>(s);
}

static ht::status strict_nan() {
    float bad[9];
    std::memcpy(bad, xyz, sizeof bad);
    bad[4] = nan_value;
    return build(ht::mesh(bad, 3), ht::options().strict());
}

static ht::status too_few_vertices() {
    ht::mesh mesh(xyz, 3);
    mesh.raw().triangle_count = 2;
    return build(mesh, ht::options());
}

static ht::status cancelled_build() {
    const auto stop = [](double) noexcept { return true; };
    return build(soup().mesh(), ht::options().progress(stop));
}

static ht::status cancelled_query() {
    const auto stop = [](double) noexcept { return true; };
    const std::vector<ht::ray> rays = many_rays(250);
    std::vector<ht::hit> hits(rays.size());
    REQUIRE(rays.size() == 100000);
    return STATUS_OF(good_tree().intersect(rays.data(), rays.size(), hits.data(),
                                           ht::query().threads(1).progress(stop)));
}

static ht::status query_flags() {
    ht::query how;
    ht::hit h;
    how.raw().flags = 1;
    return STATUS_OF(good_tree().intersect(&soup().rays[0], 1, &h, how));
}

/* Sizes and outs are written by the header, so these mistakes are made in C. */
static ht::status stats_size_0() {
    htree_stats stats = htree_stats();
    return raw(htree_get_stats(good_tree().get(), &stats));
}

static ht::status view_size_0() {
    htree_view view = htree_view();
    return raw(htree_get_view(good_tree().get(), &view));
}

static ht::status view_lazy() {
    const ht::tree tree =
        MUST(ht::tree::build(the_file().scenes.back().mesh(), ht::options(ht::kind::wide).lazy()));
    return STATUS_OF(tree.view());
}

static ht::status update(const ht::mesh &mesh, ht::how way) {
    ht::tree tree = good_tree();
    return STATUS_OF(tree.update(mesh, way));
}

static ht::status mesh_null() {
    htree *tree = nullptr;
    return raw(htree_build(&tree, nullptr, nullptr));
}

static ht::status tree_null() {
    ht::hit h;
    return STATUS_OF(ht::tree().intersect(&soup().rays[0], 1, &h));
}

static const std::map<std::string, std::function<ht::status()>> misuses = {
    {"build-index-out-of-range",
     [] {
         const std::uint32_t wild[3] = {0, 1, 3};
         return build(ht::mesh(xyz, 3).indices(wild, 1), ht::options());
     }},
    {"build-strict-nan", strict_nan},
    {"build-kind-unknown", [] { return build(ht::options(static_cast<ht::kind>(99))); }},
    {"build-buckets-1", [] { return build(ht::options().buckets(1)); }},
    {"build-axes-2", [] { return build(ht::options().axes(2)); }},
    {"build-flags-unknown",
     [] {
         ht::options how;
         how.raw().flags = 0x80000000u;
         return build(how);
     }},
    {"build-cost-nan", [] { return build(ht::options().costs(nan_value, 1, 1, 1)); }},
    {"build-cost-zero", [] { return build(ht::options().costs(1, 1, 1, 0)); }},
    {"build-cells-huge", [] { return build(ht::options().cells_per_prim(1e9f)); }},
    {"build-few-prims-0", [] { return build(ht::options().few_prims(0)); }},
    {"build-stride-8", [] { return build(ht::mesh(xyz, 3, 8), ht::options()); }},
    {"build-too-few-vertices", too_few_vertices},
    {"build-positions-null", [] { return build(ht::mesh(nullptr, 3), ht::options()); }},
    {"build-cancelled", cancelled_build},
    {"query-cancelled", cancelled_query},
    {"query-flags-unknown", query_flags},
    {"options-size-0",
     [] {
         htree_options options;
         return raw(htree_options_init(&options, 0, HTREE_H));
     }},
    {"query-size-0",
     [] {
         htree_query query;
         return raw(htree_query_init(&query, 0));
     }},
    {"stats-size-0", stats_size_0},
    {"view-size-0", view_size_0},
    {"view-lazy", view_lazy},
    {"update-how-3", [] { return update(one(), static_cast<ht::how>(3)); }},
    {"update-index-out-of-range",
     [] {
         const std::uint32_t wild[3] = {0, 1, 3};
         return update(ht::mesh(xyz, 3).indices(wild, 1), ht::how::rebuild);
     }},
    {"update-mesh-null",
     [] {
         ht::tree tree = good_tree();
         ::htree *const handle = tree.release();
         const ht::status status = raw(htree_update(handle, nullptr, HTREE_REFIT, nullptr));
         tree = ht::tree(handle);
         return status;
     }},
    {"complete-null", [] { return STATUS_OF(ht::tree().complete()); }},
    {"rays-null",
     [] {
         ht::hit h;
         return STATUS_OF(good_tree().intersect(nullptr, 1, &h));
     }},
    {"hits-null", [] { return STATUS_OF(good_tree().intersect(&soup().rays[0], 1, nullptr)); }},
    {"tree-null", tree_null},
    {"out-null",
     [] {
         const htree_mesh mesh = one().whole();
         return raw(htree_build(nullptr, &mesh, nullptr));
     }},
    {"mesh-null", mesh_null},
};

TEST_CASE("every misuse of the file is refused with its status") {
    CHECK(the_file().misuse.size() >= 25);
    for (const auto &m : the_file().misuse) {
        CAPTURE(m.first);
        const auto found = misuses.find(m.first);
        REQUIRE_MESSAGE(found != misuses.end(), "no such case here");
        CHECK(found->second() == words.at(m.second));
    }
}

TEST_CASE("an error keeps its sentence whatever fails after it") {
    const ht::error first = ERROR_OF(ht::tree::build(one(), ht::options().axes(2)));
    const std::string text = first.what();
    CHECK(text == ht::error_text());
    CHECK_REFUSED(ht::tree::build(one(), ht::options().buckets(1)), ht::status::argument);
    CHECK(text == first.what());
    CHECK(text != ht::error_text());
}
