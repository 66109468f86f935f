// SPDX-License-Identifier: MIT
export * from './index.js';
import * as htree from './index.js';
export default htree;
