/* error.hpp: names, versions and errors. Include htree.hpp.
 *
 * SPDX-License-Identifier: MIT */
#ifndef HTREE_HPP_ERROR
#define HTREE_HPP_ERROR

#include <htree.h>

#include <cstdint>
#include <cstring>
#include <exception>
#include <utility>

#if !defined(HTREE_HPP_STATUS) && !defined(__cpp_exceptions) && !defined(_CPPUNWIND)
#define HTREE_HPP_STATUS
#endif

#if __cplusplus >= 201703L || (defined(_MSVC_LANG) && _MSVC_LANG >= 201703L)
#define HTREE_HPP_NODISCARD [[nodiscard]]
#else
#define HTREE_HPP_NODISCARD
#endif

/* The two ways of errors are two sets of types, so that one program may mix both. */
#ifdef HTREE_HPP_STATUS
#define HTREE_HPP_MODE     with_status
#define HTREE_HPP_NOEXCEPT noexcept
#else
#define HTREE_HPP_MODE with_exceptions
#define HTREE_HPP_NOEXCEPT
#endif

namespace ht {
inline namespace HTREE_HPP_MODE {

/* ---- Names ---------------------------------------------------------------------------------- */

using ray = ::htree_ray;
using hit = ::htree_hit;
using box = ::htree_box;
using counters = ::htree_counters;
using stats = ::htree_stats;
using view = ::htree_view;

enum class kind : std::int32_t {
    none = 0,
    ug = HTREE_UG,
    kd = HTREE_KD,
    bvh_median = HTREE_BVH_MEDIAN,
    bvh_sah = HTREE_BVH_SAH,
    skd = HTREE_SKD,
    h = HTREE_H,
    ah = HTREE_AH,
    wide = HTREE_WIDE,
    fast = HTREE_FAST,
    balanced = HTREE_BALANCED,
    best = HTREE_BEST
};

/* How tree::update brings a tree to a mesh. */
enum class how : std::int32_t { rebuild = HTREE_REBUILD, refit = HTREE_REFIT };

enum class status : std::int32_t {
    ok = HTREE_OK,
    argument = HTREE_ERROR_ARGUMENT,
    memory = HTREE_ERROR_MEMORY,
    limit = HTREE_ERROR_LIMIT,
    geometry = HTREE_ERROR_GEOMETRY,
    cancelled = HTREE_ERROR_CANCELLED,
    unsupported = HTREE_ERROR_UNSUPPORTED,
    corrupt = HTREE_ERROR_CORRUPT,
    no_device = HTREE_ERROR_NO_DEVICE,
    device = HTREE_ERROR_DEVICE,
    device_lost = HTREE_ERROR_DEVICE_LOST,
    kernel = HTREE_ERROR_KERNEL
};

/* NULL for a number that is no kind. */
inline const char *kind_name(kind k) noexcept {
    return ::htree_kind_name(static_cast<htree_kind>(k));
}

/* kind::none for NULL or a name that is none. */
inline kind kind_from_name(const char *name) noexcept {
    return static_cast<kind>(::htree_kind_from_name(name));
}

inline const char *status_name(status s) noexcept {
    return ::htree_status_name(static_cast<htree_status>(s));
}

/* The library's sentence for the last failure on this thread; an error holds a copy of its own. */
inline const char *error_text() noexcept {
    return ::htree_error_text();
}

/* ---- Versions ------------------------------------------------------------------------------- */

/* Of the library that is linked; of the header that this was compiled with. */
inline std::uint32_t version() noexcept {
    return ::htree_version();
}

constexpr std::uint32_t header_version() noexcept {
    return HTREE_VERSION_MAJOR * 10000 + HTREE_VERSION_MINOR * 100 + HTREE_VERSION_PATCH;
}

/* One ABI lasts for a major version, and for a minor one while the major is 0. */
constexpr bool is_compatible(std::uint32_t library, std::uint32_t header) noexcept {
    return library / 10000 == header / 10000 && (header >= 10000 || library / 100 == header / 100);
}

/* ---- Errors --------------------------------------------------------------------------------- */

class error : public std::exception {
  public:
    error() noexcept : error(status::ok, "") {
    }
    error(status code, const char *text) noexcept : code_(code), text_() {
        std::strncpy(text_, text, sizeof text_ - 1);
    }

    status code() const noexcept {
        return code_;
    }
    const char *name() const noexcept {
        return status_name(code_);
    }
    const char *what() const noexcept override {
        return text_;
    }

  private:
    status code_;
    char text_[256];
};

/* A value, or the error that stands in its place: then the value is T(). */
template <class T> class HTREE_HPP_NODISCARD result {
  public:
    result(T value) noexcept : value_(std::move(value)), error_() {
    }
    result(const ht::error &why) noexcept : value_(), error_(why) {
    }

    explicit operator bool() const noexcept {
        return error_.code() == status::ok;
    }
    const ht::error &error() const noexcept {
        return error_;
    }
    T &operator*() noexcept {
        return value_;
    }
    const T &operator*() const noexcept {
        return value_;
    }
    T *operator->() noexcept {
        return &value_;
    }
    const T *operator->() const noexcept {
        return &value_;
    }

  private:
    T value_;
    ht::error error_;
};

template <> class HTREE_HPP_NODISCARD result<void> {
  public:
    result() noexcept : error_() {
    }
    result(const ht::error &why) noexcept : error_(why) {
    }

    explicit operator bool() const noexcept {
        return error_.code() == status::ok;
    }
    const ht::error &error() const noexcept {
        return error_;
    }

  private:
    ht::error error_;
};

#ifdef HTREE_HPP_STATUS
template <class T> using outcome = result<T>;
#else
template <class T> using outcome = T;
#endif

namespace detail {

template <class T> outcome<T> refuse(const error &why) HTREE_HPP_NOEXCEPT {
#ifdef HTREE_HPP_STATUS
    return why;
#else
    throw why;
#endif
}

inline error last_error(htree_status s) noexcept {
    return error(static_cast<status>(s), ::htree_error_text());
}

inline outcome<void> settle(htree_status s) HTREE_HPP_NOEXCEPT {
    return s == HTREE_OK ? outcome<void>() : refuse<void>(last_error(s));
}

template <class T> outcome<T> settle(htree_status s, T value) HTREE_HPP_NOEXCEPT {
    if (s != HTREE_OK) return refuse<T>(last_error(s));
    return outcome<T>(std::move(value));
}

} // namespace detail
} // namespace HTREE_HPP_MODE
} // namespace ht

#endif
