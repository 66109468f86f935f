// SPDX-License-Identifier: MIT
/** The C interface as it is, for those who need what {@link org.htree} leaves out. */
package org.htree.raw;
