// SPDX-License-Identifier: MIT
'use strict';

const { HTree } = require('./lib/tree');
const { Hits, Counters, NONE } = require('./lib/batches');
const { HTreeError, STATUSES } = require('./lib/errors');
const { KINDS } = require('./lib/options');
const { libraryVersion, bindingVersion } = require('./lib/version');

module.exports = {
    HTree, Hits, Counters, HTreeError, NONE, KINDS, STATUSES, libraryVersion, bindingVersion,
};
