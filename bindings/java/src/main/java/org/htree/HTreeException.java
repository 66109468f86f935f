// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.LibHTree;

/** A call of the library failed; the message is the library's own sentence. */
public class HTreeException extends RuntimeException {
    private static final long serialVersionUID = 1;

    /** The library's number. */
    private final int code;

    HTreeException(int code, String sentence) {
        super(sentence);
        this.code = code;
    }

    /**
     * What went wrong.
     *
     * @return the status, {@link Status#UNKNOWN} for a number that this binding does not know
     */
    public Status status() {
        return Status.of(code);
    }

    /**
     * The library's number for what went wrong.
     *
     * @return the number of {@code htree_status}
     */
    public int code() {
        return code;
    }

    /**
     * The library's words for {@link #code}.
     *
     * @return a short phrase, for example "bad argument"
     */
    public String words() {
        return LibHTree.htree_status_name(code);
    }

    @Override
    public String toString() {
        return getClass().getName() + ": " + status() + " (" + code + "): " + getMessage();
    }

    /** To be called on the thread that made the call, before any other: the text is per thread. */
    static void check(int code) {
        if (code != 0) {
            throw new HTreeException(code, LibHTree.htree_error_text());
        }
    }
}
