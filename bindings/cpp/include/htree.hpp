/* htree.hpp: libhtree for C++11 and later, header only, over the C ABI of htree.h.
 *
 *     ht::tree tree = ht::tree::build(ht::mesh(xyz, vertices).indices(abc, triangles),
 *                                     ht::options(ht::kind::h).threads(4));
 *     tree.intersect(rays, ray_count, hits);
 *
 * The namespace is ht because htree is a type of the C header. Nothing here computes anything:
 * what a call does, and what it refuses, is told in htree.h.
 *
 * Errors. A call that fails throws ht::error. Define HTREE_HPP_STATUS before this header, or
 * compile without exceptions, and calls that returned T return ht::result<T> and never throw.
 *
 * Callbacks run inside C code on any thread, so they must be noexcept, which the compiler checks.
 * They are taken by reference and not copied: each must outlive its last use, which for objects,
 * tasks and allocators is the tree's end.
 *
 * SPDX-License-Identifier: MIT */
#ifndef HTREE_HPP
#define HTREE_HPP

#include "htree/error.hpp"
#include "htree/options.hpp"

#include <vector>

namespace ht {
inline namespace HTREE_HPP_MODE {

/* How to ask: threads (0: all cores), what each ray cost, progress. */
class query {
  public:
    query() noexcept : raw_(), counted_(0) {
        ::htree_query_init(&raw_, sizeof raw_);
    }

    query &threads(std::uint32_t n) noexcept {
        raw_.threads = n;
        return *this;
    }

    /* One for every ray of the batch, `count` in all. */
    query &counters(ht::counters *out, std::uint64_t count) noexcept {
        raw_.counters = out;
        counted_ = count;
        return *this;
    }

    /* bool f(double fraction): true cancels the query. */
    template <class F> query &progress(F &f) noexcept {
        raw_.progress = detail::progress_of(f);
        return *this;
    }

#ifdef __cpp_lib_span
    query &counters(std::span<ht::counters> out) noexcept {
        return counters(out.data(), out.size());
    }
#endif

    /* Whether a batch of so many rays has a place for the cost of each. */
    bool fits(std::uint64_t rays) const noexcept {
        return raw_.counters == nullptr || counted_ >= rays;
    }

    htree_query &raw() noexcept {
        return raw_;
    }
    const htree_query &raw() const noexcept {
        return raw_;
    }

  private:
    htree_query raw_;
    std::uint64_t counted_;
};

/* A tree, and the only owner of it. Any number of threads may ask it at once; completing, updating,
 * closing, moving and destroying are for one thread while no other uses it. Where no thread knows
 * when that is, share it: std::make_shared<const ht::tree>(std::move(tree)). An empty or closed
 * tree refuses every call with status::argument. */
class tree {
  public:
    tree() noexcept : handle_(nullptr) {
    }
    explicit tree(::htree *adopted) noexcept : handle_(adopted) {
    }
    tree(tree &&other) noexcept : handle_(other.release()) {
    }
    tree &operator=(tree &&other) noexcept {
        if (this != &other) {
            close();
            handle_ = other.release();
        }
        return *this;
    }
    ~tree() {
        close();
    }

    static outcome<tree> build(const mesh &from, const options &how) HTREE_HPP_NOEXCEPT {
        return build(from, &how.raw());
    }
    static outcome<tree> build(const mesh &from) HTREE_HPP_NOEXCEPT {
        return build(from, nullptr);
    }

    /* The tree that was saved. Whatever the bytes are, what is loaded has been proved. */
    static outcome<tree> load(const void *file, std::uint64_t size,
                              const load_options &how = load_options()) HTREE_HPP_NOEXCEPT {
        if (!is_compatible(version(), header_version())) return refuse_library();
        ::htree *handle = nullptr;
        const htree_status s = ::htree_load(&handle, file, size, &how.raw());
        return detail::settle(s, tree(handle));
    }
    static outcome<tree> load(const std::vector<unsigned char> &file,
                              const load_options &how = load_options()) HTREE_HPP_NOEXCEPT {
        /* Of no bytes there is no address, and they are no tree. */
        static const unsigned char none = 0;
        return load(file.empty() ? &none : file.data(), file.size(), how);
    }

    /* Builds what rays have not reached yet of a lazy tree, which needs its mesh no more. */
    outcome<void> complete() HTREE_HPP_NOEXCEPT {
        return detail::settle(::htree_complete(handle_));
    }

    /* Brings the tree to the mesh, with the options that it was built with, and ends its views. The
     * value is the expected cost of a ray over that when the tree was built: from about 1.5 on
     * rebuilding pays. */
    outcome<double> update(const mesh &to, ht::how way) HTREE_HPP_NOEXCEPT {
        const htree_mesh whole = to.whole();
        double quality = 1;
        const htree_status s =
            ::htree_update(handle_, &whole, static_cast<std::int32_t>(way), &quality);
        return detail::settle(s, quality);
    }

    /* Twice is harmless. */
    void close() noexcept {
        ::htree_free(release());
    }
    explicit operator bool() const noexcept {
        return handle_ != nullptr;
    }
    const ::htree *get() const noexcept {
        return handle_;
    }
    ::htree *release() noexcept {
        ::htree *const handle = handle_;
        handle_ = nullptr;
        return handle;
    }

    /* The closest hit of every ray. Without a query, on the threads of the tree's options. */
    outcome<void> intersect(const ray *rays, std::uint64_t count,
                            hit *hits) const HTREE_HPP_NOEXCEPT {
        return detail::settle(::htree_intersect(handle_, rays, count, hits, nullptr));
    }
    outcome<void> intersect(const ray *rays, std::uint64_t count, hit *hits,
                            const query &how) const HTREE_HPP_NOEXCEPT {
        if (!how.fits(count)) return refuse_counters();
        return detail::settle(::htree_intersect(handle_, rays, count, hits, &how.raw()));
    }
    outcome<hit> intersect(const ray &one) const HTREE_HPP_NOEXCEPT {
        hit h = hit();
        const htree_status s = ::htree_intersect(handle_, &one, 1, &h, nullptr);
        return detail::settle(s, h);
    }

    /* 1 for every ray that hits anything, else 0. */
    outcome<void> occluded(const ray *rays, std::uint64_t count,
                           std::uint8_t *out) const HTREE_HPP_NOEXCEPT {
        return detail::settle(::htree_occluded(handle_, rays, count, out, nullptr));
    }
    outcome<void> occluded(const ray *rays, std::uint64_t count, std::uint8_t *out,
                           const query &how) const HTREE_HPP_NOEXCEPT {
        if (!how.fits(count)) return refuse_counters();
        return detail::settle(::htree_occluded(handle_, rays, count, out, &how.raw()));
    }
    outcome<bool> occluded(const ray &one) const HTREE_HPP_NOEXCEPT {
        std::uint8_t any = 0;
        const htree_status s = ::htree_occluded(handle_, &one, 1, &any, nullptr);
        return detail::settle(s, any != 0);
    }

#ifdef __cpp_lib_span
    outcome<void> intersect(std::span<const ray> rays,
                            std::span<hit> hits) const HTREE_HPP_NOEXCEPT {
        if (hits.size() < rays.size()) return refuse_answers();
        return intersect(rays.data(), rays.size(), hits.data());
    }
    outcome<void> intersect(std::span<const ray> rays, std::span<hit> hits,
                            const query &how) const HTREE_HPP_NOEXCEPT {
        if (hits.size() < rays.size()) return refuse_answers();
        return intersect(rays.data(), rays.size(), hits.data(), how);
    }
    outcome<void> occluded(std::span<const ray> rays,
                           std::span<std::uint8_t> out) const HTREE_HPP_NOEXCEPT {
        if (out.size() < rays.size()) return refuse_answers();
        return occluded(rays.data(), rays.size(), out.data());
    }
    outcome<void> occluded(std::span<const ray> rays, std::span<std::uint8_t> out,
                           const query &how) const HTREE_HPP_NOEXCEPT {
        if (out.size() < rays.size()) return refuse_answers();
        return occluded(rays.data(), rays.size(), out.data(), how);
    }
#endif

    outcome<box> bounds() const HTREE_HPP_NOEXCEPT {
        box b = box();
        const htree_status s = ::htree_get_bounds(handle_, &b);
        return detail::settle(s, b);
    }
    outcome<ht::stats> stats() const HTREE_HPP_NOEXCEPT {
        ht::stats all = ht::stats();
        all.size = sizeof all;
        const htree_status s = ::htree_get_stats(handle_, &all);
        return detail::settle(s, all);
    }

    /* The tree's own arrays, which end with it or its update: a tree that is about to die has no
     * view, nor has a compact one, and a lazy one only once it is complete. */
    outcome<ht::view> view() const &HTREE_HPP_NOEXCEPT {
        ht::view all = ht::view();
        all.size = sizeof all;
        const htree_status s = ::htree_get_view(handle_, &all);
        return detail::settle(s, all);
    }
    outcome<ht::view> view() const && = delete;

    /* The tree as bytes, for load; objects as their boxes. A vector that finds no memory throws. */
    outcome<std::vector<unsigned char>> save() const {
        std::vector<unsigned char> file;
        std::uint64_t bytes = 0;
        htree_status s = ::htree_save(handle_, nullptr, 0, &bytes);
        if (s == HTREE_OK) {
            file.resize(static_cast<std::size_t>(bytes));
            s = ::htree_save(handle_, file.data(), bytes, &bytes);
        }
        return detail::settle(s, std::move(file));
    }
    /* Into room for `size` bytes; how many they are. With nullptr, only how many. */
    outcome<std::uint64_t> save(void *file, std::uint64_t size) const HTREE_HPP_NOEXCEPT {
        std::uint64_t bytes = 0;
        const htree_status s = ::htree_save(handle_, file, size, &bytes);
        return detail::settle(s, bytes);
    }

    /* Proves the structure. */
    outcome<void> check() const HTREE_HPP_NOEXCEPT {
        return detail::settle(::htree_check(handle_));
    }

  private:
    static outcome<tree> build(const mesh &from, const htree_options *how) HTREE_HPP_NOEXCEPT {
        if (!is_compatible(version(), header_version())) return refuse_library();
        const htree_mesh whole = from.whole();
        ::htree *handle = nullptr;
        const htree_status s = ::htree_build(&handle, &whole, how);
        return detail::settle(s, tree(handle));
    }

    static outcome<tree> refuse_library() HTREE_HPP_NOEXCEPT {
        return detail::refuse<tree>(error(status::unsupported,
                                          "the library that is linked has another ABI than "
                                          "htree.h"));
    }
    static outcome<void> refuse_counters() HTREE_HPP_NOEXCEPT {
        return detail::refuse<void>(error(status::argument, "fewer counters than rays"));
    }
    static outcome<void> refuse_answers() HTREE_HPP_NOEXCEPT {
        return detail::refuse<void>(error(status::argument, "fewer places for answers than rays"));
    }

    ::htree *handle_;
};

} // namespace HTREE_HPP_MODE
} // namespace ht

#endif
