// SPDX-License-Identifier: MIT
package org.htree;

import com.sun.jna.Pointer;
import org.htree.raw.Callbacks;

/** Carries calls of C to a {@link Progress}, and what it throws past C. */
final class ProgressCallback implements Callbacks.Report {
    private final Progress progress;
    private Throwable thrown;

    private ProgressCallback(Progress progress) {
        this.progress = progress;
    }

    static ProgressCallback of(Progress progress) {
        return progress == null ? null : new ProgressCallback(progress);
    }

    @Override
    public int invoke(Pointer user, double fraction) {
        try {
            return progress.report(fraction) ? 1 : 0;
        } catch (Throwable caught) {
            thrown = caught;
            return 1;
        }
    }

    boolean hasThrown() {
        return thrown != null;
    }

    RuntimeException thrown() {
        return Thrown.unchecked(thrown);
    }
}
