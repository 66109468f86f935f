// SPDX-License-Identifier: MIT
'use strict';

const raw = require('./raw');
const { VERSION, numbers, dotted } = require('./library');

const libraryVersion = () => dotted(numbers(raw.htree_version()));
const bindingVersion = () => dotted(VERSION);

module.exports = { libraryVersion, bindingVersion };
