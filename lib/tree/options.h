/* options.h: reading what the caller put into htree_options. */
#ifndef HT_OPTIONS_H
#define HT_OPTIONS_H

#include "base/base.h"

/* Copies *given, of whatever version, into *options and checks every field; NULL: the defaults. */
htree_status ht_options_read(const htree_options *given, htree_options *options);

#endif
