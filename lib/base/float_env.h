/* float_env.h: the floating-point environment of a call. Answers are the same bits whatever the
 * caller's thread has set: a rounding mode, denormals as zero (any library that was linked with
 * -ffast-math may have done so), traps. */
#ifndef HT_FLOAT_ENV_H
#define HT_FLOAT_ENV_H

#include "base.h"

#if defined(__SSE2__) || defined(_M_X64)
#include <xmmintrin.h>

typedef uint32_t ht_float_env;

/* All that MXCSR is told, without what it tells: to nearest, denormals are numbers, no traps. */
enum { HT_MXCSR_MODES = 0xffc0, HT_MXCSR_DEFAULT = 0x1f80 };

HT_INLINE bool ht_float_env_is_default(ht_float_env env) {
    return (env & HT_MXCSR_MODES) == HT_MXCSR_DEFAULT;
}

/* Returns what the thread had. */
HT_INLINE ht_float_env ht_float_env_enter(void) {
    const ht_float_env env = _mm_getcsr();
    if (HT_UNLIKELY(!ht_float_env_is_default(env))) _mm_setcsr(HT_MXCSR_DEFAULT);
    return env;
}

HT_INLINE void ht_float_env_leave(ht_float_env env) {
    if (HT_UNLIKELY(!ht_float_env_is_default(env))) _mm_setcsr(env);
}

#else
#include <fenv.h>

typedef fenv_t ht_float_env;

HT_INLINE ht_float_env ht_float_env_enter(void) {
    ht_float_env env;
    fegetenv(&env);
    fesetenv(FE_DFL_ENV);
    return env;
}

HT_INLINE void ht_float_env_leave(ht_float_env env) {
    fesetenv(&env);
}

#endif

/* Returns `call`, made in the default environment: all that public functions with arithmetic do. */
#define HT_RETURN_IN_DEFAULT_ENV(call)                                                             \
    do {                                                                                           \
        const ht_float_env entry_env = ht_float_env_enter();                                       \
        const htree_status entry_status = (call);                                                  \
        ht_float_env_leave(entry_env);                                                             \
        return entry_status;                                                                       \
    } while (0)

#endif
