/* suggest.h: the word that somebody meant. */
#ifndef EXAMPLES_SUGGEST_H
#define EXAMPLES_SUGGEST_H

/* The better of two words so far: `best`, which may be NULL, or `word`, if fewer letters have to be
 * changed, added, left out or swapped for `text`, and not more than a third of them. */
const char *suggest(const char *text, const char *best, const char *word);

#endif
