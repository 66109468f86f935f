/* common.hpp: one text of tests for both ways of errors, and the scenes of the conformance file. */
#ifndef COMMON_HPP
#define COMMON_HPP

#include <htree.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <string>
#include <vector>

/* MUST(call): its value; the test fails if the call does. STATUS_OF(call): how it ends. */
#ifdef HTREE_HPP_STATUS
template <class T> T take(ht::result<T> r) {
    if (!r) MESSAGE(r.error().what());
    CHECK(r);
    return std::move(*r);
}
inline void take(const ht::result<void> &r) {
    if (!r) MESSAGE(r.error().what());
    CHECK(r);
}
#define MUST(call)     take(call)
#define ERROR_OF(call) (call).error()
#else
#define MUST(call)     call
template <class F> ht::error error_of(F call) {
    try {
        call();
    } catch (const ht::error &e) {
        return e;
    }
    return ht::error();
}
#define ERROR_OF(call) error_of([&] { (void)(call); })
#endif
#define STATUS_OF(call) ERROR_OF(call).code()

/* A refusal has a status and a sentence. */
#define CHECK_REFUSED(call, wanted)                                                                \
    do {                                                                                           \
        const ht::error why_ = ERROR_OF(call);                                                     \
        CHECK(why_.code() == (wanted));                                                            \
        CHECK(std::strlen(why_.what()) > 5);                                                       \
    } while (0)

/* ---- Scenes --------------------------------------------------------------------------------- */

struct scene {
    std::string name;
    std::vector<float> xyz;
    std::vector<std::uint32_t> abc;
    bool indexed;
    ht::box bounds;
    std::uint64_t triangles, objects, invalid, degenerate;
    std::vector<ht::ray> rays;
    std::vector<ht::hit> hits;
    std::vector<std::uint8_t> occluded;

    ht::mesh mesh() const {
        ht::mesh m(xyz.data(), xyz.size() / 3);
        if (indexed) m.indices(abc.data(), abc.size() / 3);
        return m;
    }
};

struct conformance {
    std::string library;
    std::vector<scene> scenes;
    std::vector<std::string> kinds;
    std::map<std::string, int> statuses;
    std::map<int, std::string> status_names;
    std::vector<std::pair<std::string, std::string>> misuse;
};

/* The file named by HTREE_CONFORMANCE, read once; the program ends if there is none. */
const conformance &the_file();

inline const scene &soup() {
    return the_file().scenes.at(0);
}

inline bool same_bits(const std::vector<ht::hit> &a, const std::vector<ht::hit> &b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

inline ht::tree good_tree(ht::options how = ht::options()) {
    return MUST(ht::tree::build(soup().mesh(), how));
}

/* The rays of the soup, `copies` times over. */
inline std::vector<ht::ray> many_rays(std::size_t copies) {
    std::vector<ht::ray> rays;
    for (std::size_t i = 0; i < copies; ++i)
        rays.insert(rays.end(), soup().rays.begin(), soup().rays.end());
    return rays;
}

#endif
