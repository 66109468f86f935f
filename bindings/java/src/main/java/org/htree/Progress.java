// SPDX-License-Identifier: MIT
package org.htree;

/** Hears how far a build or a query is, on the thread that made the call. */
@FunctionalInterface
public interface Progress {
    /**
     * Reports progress. What this throws cancels the call and is thrown out of it.
     *
     * @param fraction from 0 to 1, not decreasing within a call
     * @return true to cancel the call, which then throws {@link Status#CANCELLED}
     */
    boolean report(double fraction);
}
