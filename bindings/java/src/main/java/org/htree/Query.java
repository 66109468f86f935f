// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.LibHTree;
import org.htree.raw.Structs;

/**
 * How to query. Immutable; change one field with the methods named {@code with...}.
 *
 * @param threads 0 all cores, 1 the caller's, n at most n
 * @param counters get what each ray cost, or null; counting costs a little time
 * @param progress of the query, or null
 */
public record Query(int threads, Counters counters, Progress progress) {
    /** All cores, no counters, no progress. */
    public static final Query DEFAULT = new Query(0, null, null);

    /**
     * This query on other threads.
     *
     * @param value 0 all cores, 1 the caller's, n at most n
     * @return a new query
     */
    public Query withThreads(int value) {
        return new Query(value, counters, progress);
    }

    /**
     * This query with counters.
     *
     * @param value room for at least as many as there are rays, or null
     * @return a new query
     */
    public Query withCounters(Counters value) {
        return new Query(threads, value, progress);
    }

    /**
     * This query with progress.
     *
     * @param value or null
     * @return a new query
     */
    public Query withProgress(Progress value) {
        return new Query(threads, counters, value);
    }

    /** The struct holds addresses: this query must stay reachable while it is used. */
    Structs.Query toStruct(ProgressCallback callback) {
        Structs.Query struct = new Structs.Query();
        HTreeException.check(LibHTree.htree_query_init(struct, struct.size()));
        struct.threads = requireThreads(threads);
        struct.counters = counters == null ? null : Direct.address(counters.buffer());
        struct.progress.report = callback;
        struct.setAutoRead(false);
        return struct;
    }

    /** The library would take a negative number for very many. */
    static int requireThreads(int threads) {
        if (threads < 0) {
            throw new IllegalArgumentException("threads is " + threads);
        }
        return threads;
    }
}
