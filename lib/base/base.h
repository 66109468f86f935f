/* base.h: what every file of the library starts from: the public types, and four small tools. */
#ifndef HT_BASE_H
#define HT_BASE_H

#include "htree.h"

#include <assert.h>
#include <float.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#if defined(__FAST_MATH__) || defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "libhtree needs IEEE arithmetic: NaN and infinity are defined inputs"
#endif
#if FLT_EVAL_METHOD
#error "libhtree needs floats rounded at every step: on 32-bit x86, -msse2 -mfpmath=sse"
#endif

#if defined(__GNUC__)
#ifndef HT_INLINE /* reports of coverage have functions once */
#define HT_INLINE static inline __attribute__((always_inline))
#endif
#define HT_NOINLINE            __attribute__((noinline))
#define HT_ALIGNED(bytes)      __attribute__((aligned(bytes)))
#define HT_UNLIKELY(x)         __builtin_expect(!!(x), 0)
#define HT_PREFETCH(address)   __builtin_prefetch(address)
#define HT_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define HT_INLINE static inline
#define HT_NOINLINE
#define HT_UNLIKELY(x)       (x)
#define HT_PREFETCH(address) ((void)(address))
#define HT_PRINTF(text, first)
#endif

/* Returns from the calling function with the first failing status. */
#define HT_TRY(expression)                                                                         \
    do {                                                                                           \
        const htree_status try_status = (expression);                                              \
        if (HT_UNLIKELY(try_status != HTREE_OK)) return try_status;                                \
    } while (0)

/* Stores the text that htree_error_text will return on this thread, and returns `status`. */
htree_status ht_fail(htree_status status, const char *format, ...) HT_PRINTF(2, 3);

#endif
