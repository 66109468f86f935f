// SPDX-License-Identifier: MIT
package org.htree;

import com.google.gson.Gson;
import java.io.IOException;
import java.io.Reader;
import java.io.UncheckedIOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.Map;

/** The file that the C library's own tests write; every binding must agree with it. */
final class Conformance {
    int format;
    String library;
    List<Scene> scenes;
    List<String> kinds;
    Map<String, Integer> statuses;
    @com.google.gson.annotations.SerializedName("status_names")
    Map<String, String> statusNames;
    List<Misuse> misuse;

    /** A mesh, rays, and what they hit; floats are given as their bits. */
    static final class Scene {
        String name;
        long[] positions;
        long[] indices;
        long[] bounds;
        SceneStats stats;
        long[] rays;
        long[] hits;
        int[] occluded;

        @Override
        public String toString() {
            return name;
        }

        Mesh mesh() {
            Mesh.Builder builder = Mesh.builder().positions(Fixtures.floats(words(positions)));
            return (indices == null ? builder : builder.indices(Fixtures.ints(words(indices))))
                    .build();
        }

        Rays traced() {
            return Rays.wrap(Fixtures.floats(words(rays)));
        }
    }

    /** What the library skipped. */
    static final class SceneStats {
        long triangles;
        long objects;
        long invalid;
        long degenerate;
    }

    /** A mistake, and the status it must give. */
    static final class Misuse {
        @com.google.gson.annotations.SerializedName("case")
        String name;
        String status;
    }

    static Conformance read() {
        try (Reader reader = Files.newBufferedReader(
                Path.of(System.getProperty("htree.conformance")))) {
            return new Gson().fromJson(reader, Conformance.class);
        } catch (IOException problem) {
            throw new UncheckedIOException(problem);
        }
    }

    static int[] words(long[] unsigned) {
        int[] words = new int[unsigned.length];
        for (int i = 0; i < words.length; ++i) {
            words[i] = (int) unsigned[i];
        }
        return words;
    }
}
