// SPDX-License-Identifier: MIT
package org.htree.raw;

import static org.junit.jupiter.api.Assertions.assertDoesNotThrow;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertNotEquals;
import static org.junit.jupiter.api.Assertions.assertThrows;
import static org.junit.jupiter.api.Assertions.assertTrue;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.List;
import org.htree.HTree;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.condition.EnabledIfSystemProperty;

/** Which library is loaded, and which is refused. */
class LoaderTest {
    /** Prints what was loaded; run in a VM of its own, for a VM loads once. */
    static final class Print {
        private Print() {}

        public static void main(String[] arguments) {
            System.out.println("loaded " + HTree.libraryVersion());
        }
    }

    private record Run(int exit, String output) {}

    private static Run load(String libraryPath) throws IOException, InterruptedException {
        Process process = new ProcessBuilder(List.of(
                Path.of(System.getProperty("java.home"), "bin", "java").toString(),
                "-cp", System.getProperty("java.class.path"),
                "-Djna.library.path=" + libraryPath, Print.class.getName()))
                .redirectErrorStream(true).start();
        String output =
                new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        return new Run(process.waitFor(), output);
    }

    @Test
    void versionsOfThisAbiAreTaken() {
        int ours = 10000 * LibHTree.VERSION_MAJOR + 100 * LibHTree.VERSION_MINOR;
        assertDoesNotThrow(() -> Loader.requireCompatible(ours, "libhtree"));
        assertDoesNotThrow(() -> Loader.requireCompatible(ours + 99, "libhtree"));
        assertThrows(UnsatisfiedLinkError.class,
                () -> Loader.requireCompatible(ours + 100, "libhtree"));
        assertThrows(UnsatisfiedLinkError.class,
                () -> Loader.requireCompatible(ours + 10000, "libhtree"));
    }

    @Test
    void libraryComesFromTheClassPath() throws IOException, InterruptedException {
        Run run = load("/nowhere");
        assertTrue(run.output().endsWith("loaded " + HTree.libraryVersion() + "\n"), run.output());
        assertEquals(0, run.exit());
    }

    @Test
    @EnabledIfSystemProperty(named = "htree.skew.dir", matches = ".+")
    void libraryPathComesFirstAndAnotherAbiIsRefused() throws IOException, InterruptedException {
        Run run = load(System.getProperty("htree.skew.dir"));
        assertNotEquals(0, run.exit());
        assertTrue(run.output().contains("UnsatisfiedLinkError"), run.output());
        String refusal = "has version 0.2.0; this binding needs 0.1";
        assertTrue(run.output().contains(refusal), run.output());
    }
}
