/* to_front.h: which lanes move to the front, for vector units that have no instruction for it:
 * byte k of row m, counted from the lowest, is the number of the k-th lane of mask m. */
#ifndef HT_TO_FRONT_H
#define HT_TO_FRONT_H

#include <stdint.h>

#define HT_FRONT_LANE(m, k) (uint64_t)((m) >> (k)&1)
#define HT_FRONT_COUNT(m, k)                                                                       \
    (((k) > 0 ? HT_FRONT_LANE(m, 0) : 0) + ((k) > 1 ? HT_FRONT_LANE(m, 1) : 0) +                   \
     ((k) > 2 ? HT_FRONT_LANE(m, 2) : 0) + ((k) > 3 ? HT_FRONT_LANE(m, 3) : 0) +                   \
     ((k) > 4 ? HT_FRONT_LANE(m, 4) : 0) + ((k) > 5 ? HT_FRONT_LANE(m, 5) : 0) +                   \
     ((k) > 6 ? HT_FRONT_LANE(m, 6) : 0))
#define HT_FRONT_PLACE(m, k) (HT_FRONT_LANE(m, k) * ((uint64_t)(k) << 8 * HT_FRONT_COUNT(m, k)))
#define HT_FRONT_ROW(m)                                                                            \
    (HT_FRONT_PLACE(m, 0) + HT_FRONT_PLACE(m, 1) + HT_FRONT_PLACE(m, 2) + HT_FRONT_PLACE(m, 3) +   \
     HT_FRONT_PLACE(m, 4) + HT_FRONT_PLACE(m, 5) + HT_FRONT_PLACE(m, 6) + HT_FRONT_PLACE(m, 7))
#define HT_FRONT_ROWS4(m)                                                                          \
    HT_FRONT_ROW(m), HT_FRONT_ROW((m) + 1), HT_FRONT_ROW((m) + 2), HT_FRONT_ROW((m) + 3)
#define HT_FRONT_ROWS16(m)                                                                         \
    HT_FRONT_ROWS4(m), HT_FRONT_ROWS4((m) + 4), HT_FRONT_ROWS4((m) + 8), HT_FRONT_ROWS4((m) + 12)
#define HT_FRONT_ROWS64(m)                                                                         \
    HT_FRONT_ROWS16(m), HT_FRONT_ROWS16((m) + 16), HT_FRONT_ROWS16((m) + 32),                      \
        HT_FRONT_ROWS16((m) + 48)

static const uint64_t ht_to_front[256] = {HT_FRONT_ROWS64(0), HT_FRONT_ROWS64(64),
                                          HT_FRONT_ROWS64(128), HT_FRONT_ROWS64(192)};

#endif
