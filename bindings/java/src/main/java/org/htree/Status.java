// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.LibHTree;

/** What a call of the library can come to: the one table of its statuses. */
public enum Status {
    /** All went well. */
    OK(0),
    /** A size, a flag or a number that the call does not take. */
    ARGUMENT(1),
    /** There was no memory. */
    MEMORY(2),
    /** More objects than the structure can address. */
    LIMIT(3),
    /** An index beyond the vertices; with {@link Options#strict} bad numbers too. */
    GEOMETRY(4),
    /** The progress hook asked to stop. */
    CANCELLED(5),
    /** This build of the library lacks the kind that was asked for. */
    UNSUPPORTED(6),
    /** {@link HTree#check} found a broken tree. */
    CORRUPT(7),
    /** No device of that name. */
    NO_DEVICE(8),
    /** A call to a device failed. */
    DEVICE(9),
    /** A device is gone, with all that was on it. */
    DEVICE_LOST(10),
    /** A device's compiler refused a kernel. */
    KERNEL(11),
    /** A status that a newer library knows and this binding does not. */
    UNKNOWN(-1);

    private final int code;

    Status(int code) {
        this.code = code;
    }

    /**
     * The library's number.
     *
     * @return the number of {@code htree_status}
     */
    public int code() {
        return code;
    }

    /**
     * The library's words, for logs.
     *
     * @return a short phrase, for example "bad argument"
     */
    public String words() {
        return LibHTree.htree_status_name(code);
    }

    /**
     * The status of a number.
     *
     * @param code a number of {@code htree_status}
     * @return its status, or {@link #UNKNOWN}
     */
    public static Status of(int code) {
        for (Status status : values()) {
            if (status.code == code) {
                return status;
            }
        }
        return UNKNOWN;
    }
}
