/* refuse.h: bad calls, and what they must leave behind: a status, a text of their own, and NULL. */
#ifndef REFUSE_H
#define REFUSE_H

#include "suite.h"

/* Calls refused so far. */
uint64_t refusals(void);

/* One triangle. */
htree_mesh good_mesh(void);

void set_error_text(void);
void assert_refused(htree_status is, htree_status should);
void assert_not_built(const htree_mesh *mesh, const htree_options *options, htree_status should);

#endif
