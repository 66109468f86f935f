// SPDX-License-Identifier: MIT
import htree from './index.js';

export const {
    HTree, Hits, Counters, HTreeError, NONE, KINDS, STATUSES, libraryVersion, bindingVersion,
} = htree;
export default htree;
