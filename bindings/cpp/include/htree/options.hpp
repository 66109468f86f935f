/* options.hpp: how to build, and from what. Include htree.hpp.
 *
 * SPDX-License-Identifier: MIT */
#ifndef HTREE_HPP_OPTIONS
#define HTREE_HPP_OPTIONS

#include "error.hpp"

#include <memory>
#include <type_traits>

#if __cplusplus >= 202002L || (defined(_MSVC_LANG) && _MSVC_LANG >= 202002L)
#include <span>
#endif

/* Without exceptions nothing throws, whatever a declaration leaves open. */
#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define HTREE_HPP_IS_NOEXCEPT(call) noexcept(call)
#else
#define HTREE_HPP_IS_NOEXCEPT(call) true
#endif

namespace ht {
inline namespace HTREE_HPP_MODE {

/* ---- Callbacks ------------------------------------------------------------------------------ */

/* What a tasks hook is handed: calls task number i. */
class task {
  public:
    task(void (*run)(void *, std::uint32_t), void *data) noexcept : run_(run), data_(data) {
    }
    void operator()(std::uint32_t i) const noexcept {
        run_(data_, i);
    }

  private:
    void (*run_)(void *, std::uint32_t);
    void *data_;
};

namespace detail {

template <class F> void *address(F &f) noexcept {
    static_assert(std::is_object<F>::value, "a callback is an object: a lambda, not a function");
    return const_cast<void *>(static_cast<const void *>(std::addressof(f)));
}

template <class F> htree_progress progress_of(F &f) noexcept {
    static_assert(HTREE_HPP_IS_NOEXCEPT(f(0.5)), "progress callbacks must be noexcept");
    struct thunk {
        static std::int32_t report(void *user, double fraction) noexcept {
            return (*static_cast<F *>(user))(fraction) ? 1 : 0;
        }
    };
    return htree_progress{thunk::report, address(f)};
}

template <class F> htree_tasks tasks_of(F &f) noexcept {
    static_assert(HTREE_HPP_IS_NOEXCEPT(f(1u, std::declval<task>())),
                  "tasks callbacks must be noexcept");
    struct thunk {
        static void run(void *user, std::uint32_t count, void (*one)(void *, std::uint32_t),
                        void *data) noexcept {
            (*static_cast<F *>(user))(count, task(one, data));
        }
    };
    return htree_tasks{thunk::run, address(f)};
}

template <class A> htree_allocator allocator_of(A &a) noexcept {
    static_assert(HTREE_HPP_IS_NOEXCEPT(a.allocate(1u, 1u)) &&
                      HTREE_HPP_IS_NOEXCEPT(a.release(nullptr, 1u)),
                  "allocate and release must be noexcept");
    struct thunk {
        static void *allocate(void *user, std::uint64_t bytes, std::uint64_t align) noexcept {
            return static_cast<A *>(user)->allocate(bytes, align);
        }
        static void release(void *user, void *memory, std::uint64_t bytes) noexcept {
            static_cast<A *>(user)->release(memory, bytes);
        }
    };
    return htree_allocator{thunk::allocate, thunk::release, address(a)};
}

/* The function that stands for f, whose address is its user. */
template <class F> htree_object_intersect intersect_of() noexcept {
    static_assert(HTREE_HPP_IS_NOEXCEPT(
                      std::declval<F &>()(0u, std::declval<const ray &>(), std::declval<hit &>())),
                  "object callbacks must be noexcept");
    struct thunk {
        static std::int32_t intersect(void *user, std::uint32_t object, const ray *r,
                                      hit *h) noexcept {
            return (*static_cast<F *>(user))(object, *r, *h) ? 1 : 0;
        }
    };
    return thunk::intersect;
}

} // namespace detail

/* ---- Options -------------------------------------------------------------------------------- */

/* The defaults of a kind, and what is set after them. A number that is no kind is refused by
 * tree::build. */
class options {
  public:
    explicit options(ht::kind k = ht::kind::balanced) noexcept : raw_() {
        const htree_kind wanted = static_cast<htree_kind>(k);
        if (::htree_options_init(&raw_, sizeof raw_, wanted) == HTREE_OK) return;
        ::htree_options_init(&raw_, sizeof raw_, HTREE_BALANCED);
        raw_.kind = wanted;
    }

    /* The kind that will be built: a preset has become one. */
    ht::kind kind() const noexcept {
        return static_cast<ht::kind>(raw_.kind);
    }

    options &threads(std::uint32_t n) noexcept {
        raw_.threads = n;
        return *this;
    }
    options &strict(bool on = true) noexcept {
        return flag(HTREE_STRICT, on);
    }
    options &any_planes(bool on = true) noexcept {
        return flag(HTREE_ANY_PLANES, on);
    }
    options &loose_planes(bool on = true) noexcept {
        return flag(HTREE_LOOSE_PLANES, on);
    }
    options &morton(bool on = true) noexcept {
        return flag(HTREE_MORTON, on);
    }
    /* Then the tree borrows the mesh's arrays until tree::complete or its end. */
    options &lazy(bool on = true) noexcept {
        return flag(HTREE_LAZY, on);
    }
    options &compact(bool on = true) noexcept {
        return flag(HTREE_COMPACT, on);
    }
    options &collapse(bool on = true) noexcept {
        return flag(HTREE_COLLAPSE, on);
    }
    options &buckets(std::uint32_t n) noexcept {
        raw_.buckets = n;
        return *this;
    }
    options &axes(std::uint32_t n) noexcept {
        raw_.axes = n;
        return *this;
    }
    options &costs(float skd, float bv2, float bv6, float intersect) noexcept {
        raw_.cost_skd = skd;
        raw_.cost_bv2 = bv2;
        raw_.cost_bv6 = bv6;
        raw_.cost_intersect = intersect;
        return *this;
    }
    options &cells_per_prim(float n) noexcept {
        raw_.cells_per_prim = n;
        return *this;
    }
    options &few_prims(std::uint32_t n) noexcept {
        raw_.few_prims = n;
        return *this;
    }

    /* bool f(double fraction): true cancels the build. */
    template <class F> options &progress(F &f) noexcept {
        raw_.progress = detail::progress_of(f);
        return *this;
    }

    /* void f(uint32_t count, ht::task task): calls task(i) once for every i below count. */
    template <class F> options &tasks(F &f) noexcept {
        raw_.tasks = detail::tasks_of(f);
        return *this;
    }

    /* void *a.allocate(uint64_t bytes, uint64_t alignment); void a.release(void *, uint64_t). */
    template <class A> options &allocator(A &a) noexcept {
        raw_.allocator = detail::allocator_of(a);
        return *this;
    }

    /* Measures the four costs on this machine. */
    outcome<void> calibrate() HTREE_HPP_NOEXCEPT {
        return detail::settle(::htree_calibrate(&raw_));
    }

    htree_options &raw() noexcept {
        return raw_;
    }
    const htree_options &raw() const noexcept {
        return raw_;
    }

  private:
    options &flag(std::uint32_t bit, bool on) noexcept {
        raw_.flags = on ? raw_.flags | bit : raw_.flags & ~bit;
        return *this;
    }

    htree_options raw_;
};

/* How tree::load loads. */
class load_options {
  public:
    load_options() noexcept : raw_() {
        ::htree_load_options_init(&raw_, sizeof raw_);
    }

    /* Of queries. */
    load_options &threads(std::uint32_t n) noexcept {
        raw_.threads = n;
        return *this;
    }
    /* Refer to the bytes, which lie at a multiple of 64 and outlive the tree, instead of copying
     * them. */
    load_options &borrow(bool on = true) noexcept {
        raw_.flags = on ? raw_.flags | HTREE_BORROW : raw_.flags & ~std::uint32_t(HTREE_BORROW);
        return *this;
    }

    /* As in mesh and in options. */
    template <class F> load_options &objects(F &f) noexcept {
        raw_.intersect = detail::intersect_of<F>();
        raw_.user = detail::address(f);
        return *this;
    }
    template <class F> load_options &tasks(F &f) noexcept {
        raw_.tasks = detail::tasks_of(f);
        return *this;
    }
    template <class A> load_options &allocator(A &a) noexcept {
        raw_.allocator = detail::allocator_of(a);
        return *this;
    }

    htree_load_options &raw() noexcept {
        return raw_;
    }
    const htree_load_options &raw() const noexcept {
        return raw_;
    }

  private:
    htree_load_options raw_;
};

/* ---- Mesh ----------------------------------------------------------------------------------- */

/* Borrowed arrays, until tree::build or tree::update returns; a lazy tree borrows them until it is
 * complete. */
class mesh {
  public:
    mesh() noexcept : raw_(), objects_() {
    }

    /* x y z of every vertex, `stride` bytes apart (0: 12). Without indices, each three vertices are
     * a triangle. */
    mesh(const float *xyz, std::uint64_t vertices, std::uint64_t stride = 0) noexcept : mesh() {
        raw_.positions = xyz;
        raw_.position_stride = stride;
        raw_.vertex_count = vertices;
        raw_.triangle_count = vertices / 3;
    }

    /* Structs that begin with three floats: vectors of any library, vertices with more to them. */
    template <class V>
    mesh(const V *vertices, std::uint64_t count) noexcept
        : mesh(reinterpret_cast<const float *>(vertices), count, sizeof(V)) {
        static_assert(std::is_standard_layout<V>::value && sizeof(V) >= 12 && sizeof(V) % 4 == 0 &&
                          alignof(V) >= alignof(float),
                      "a vertex begins with three floats");
    }

    mesh &indices(const std::uint32_t *abc, std::uint64_t triangles) noexcept {
        raw_.indices = abc;
        raw_.triangle_count = triangles;
        return *this;
    }

    /* bool f(uint32_t object, const ray &, hit &): see htree_object_intersect. */
    template <class F> mesh &objects(const box *boxes, std::uint64_t count, F &f) noexcept {
        objects_ = htree_objects{boxes, count, detail::intersect_of<F>(), detail::address(f)};
        return *this;
    }

#ifdef __cpp_lib_span
    explicit mesh(std::span<const float> xyz) noexcept : mesh(xyz.data(), xyz.size() / 3) {
    }
    mesh &indices(std::span<const std::uint32_t> abc) noexcept {
        return indices(abc.data(), abc.size() / 3);
    }
#endif

    htree_mesh &raw() noexcept {
        return raw_;
    }

    /* With the objects, which are pointed to inside *this. */
    htree_mesh whole() const noexcept {
        htree_mesh whole = raw_;
        if (objects_.count != 0) whole.objects = &objects_;
        return whole;
    }

  private:
    htree_mesh raw_;
    htree_objects objects_;
};

} // namespace HTREE_HPP_MODE
} // namespace ht

#endif
