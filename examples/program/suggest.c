/* suggest.c: edit distance with swaps of neighbours (optimal string alignment). */
#include "suggest.h"

#include <string.h>

enum { LONGEST = 31 };

static unsigned least(unsigned a, unsigned b) {
    return a < b ? a : b;
}

static unsigned distance(const char *a, const char *b) {
    const size_t n = strlen(a), m = strlen(b);
    unsigned row[LONGEST + 1][LONGEST + 1];
    if (n > LONGEST || m > LONGEST) return LONGEST;
    for (size_t i = 0; i <= n; ++i) {
        for (size_t j = 0; j <= m; ++j) {
            if (i == 0 || j == 0) {
                row[i][j] = (unsigned)(i + j);
                continue;
            }
            const unsigned change = row[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            row[i][j] = least(change, 1 + least(row[i - 1][j], row[i][j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[i][j] = least(row[i][j], 1 + row[i - 2][j - 2]);
        }
    }
    return row[n][m];
}

const char *suggest(const char *text, const char *best, const char *word) {
    const unsigned far = distance(text, word), most = 1 + (unsigned)strlen(text) / 3;
    if (far > most || far >= strlen(word)) return best;
    return best && distance(text, best) <= far ? best : word;
}
