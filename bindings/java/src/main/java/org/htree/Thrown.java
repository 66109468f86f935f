// SPDX-License-Identifier: MIT
package org.htree;

import java.lang.reflect.UndeclaredThrowableException;

/** What a callback threw, on its way past C. */
final class Thrown {
    private Thrown() {}

    /** It, to be thrown; an Error is thrown at once. */
    static RuntimeException unchecked(Throwable thrown) {
        if (thrown instanceof Error error) {
            throw error;
        }
        return thrown instanceof RuntimeException exception
                ? exception : new UndeclaredThrowableException(thrown);
    }
}
