// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertFalse;

import java.nio.ByteBuffer;
import java.util.ArrayList;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.Stream;
import org.htree.Conformance.Scene;
import org.junit.jupiter.api.DynamicTest;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.TestFactory;

/** Every kind gives the C library's bits, on one thread and on all. */
class ConformanceTest {
    private static final Conformance FILE = Conformance.read();

    @TestFactory
    Stream<DynamicTest> sceneGivesTheBitsOfC() {
        assertEquals(1, FILE.format);
        assertFalse(FILE.scenes.isEmpty() || FILE.kinds.isEmpty());
        List<DynamicTest> tests = new ArrayList<>();
        for (Scene scene : FILE.scenes) {
            for (String kind : FILE.kinds) {
                tests.add(DynamicTest.dynamicTest(scene + " " + kind, () -> {
                    agree(scene, Kind.fromLabel(kind), 1);
                    agree(scene, Kind.fromLabel(kind), 0);
                }));
            }
        }
        return tests.stream();
    }

    private static void agree(Scene scene, Kind kind, int threads) {
        Options options = Options.builder(kind).threads(threads).build();
        try (HTree tree = HTree.build(scene.mesh(), options)) {
            assertAnswers(scene, tree);
            Box box = tree.bounds();
            float[] bounds = {
                box.loX(), box.loY(), box.loZ(), box.hiX(), box.hiY(), box.hiZ()};
            for (int i = 0; i < bounds.length; ++i) {
                assertEquals((int) scene.bounds[i], Float.floatToRawIntBits(bounds[i]));
            }
            Stats stats = tree.stats();
            assertEquals(kind, stats.kind());
            assertEquals(scene.stats.triangles, stats.triangles());
            assertEquals(scene.stats.objects, stats.objects());
            assertEquals(scene.stats.invalid, stats.invalid());
            assertEquals(scene.stats.degenerate, stats.degenerate());
        }
    }

    private static void assertAnswers(Scene scene, HTree tree) {
        Rays rays = scene.traced();
        tree.check();
        assertArrayEquals(Conformance.words(scene.hits), Fixtures.words(tree.intersect(rays)));
        ByteBuffer occluded = tree.occluded(rays);
        for (int i = 0; i < rays.count(); ++i) {
            assertEquals(scene.occluded[i], occluded.get(i), "ray " + i);
        }
    }

    @Test
    void lazyTreesAndCompleteOnesGiveTheBitsOfC() {
        Options lazy = Options.builder(Kind.WIDE).lazy(true).build();
        for (Scene scene : FILE.scenes) {
            try (HTree tree = HTree.build(scene.mesh(), lazy)) {
                assertAnswers(scene, tree);
                tree.complete();
                assertAnswers(scene, tree);
            }
        }
    }

    @Test
    void treeThatGoesFromSceneToSceneGivesTheBitsOfC() {
        for (String kind : FILE.kinds) {
            Options options = Options.of(Kind.fromLabel(kind));
            try (HTree tree = HTree.build(Mesh.builder().build(), options)) {
                for (Scene scene : FILE.scenes) {
                    for (How how : How.values()) {
                        tree.update(scene.mesh(), how);
                        assertAnswers(scene, tree);
                    }
                }
            }
        }
    }

    @Test
    void oneRayGivesTheBitsOfItsBatch() {
        for (Scene scene : FILE.scenes) {
            Rays rays = scene.traced();
            int[] expected = Conformance.words(scene.hits);
            try (HTree tree = HTree.build(scene.mesh())) {
                for (int i = 0; i < rays.count(); ++i) {
                    Hit hit = tree.intersect(rays.get(i));
                    assertEquals(expected[4 * i + 3], hit.prim());
                    assertEquals(expected[4 * i + 1], Float.floatToRawIntBits(hit.u()));
                    assertEquals(expected[4 * i + 2], Float.floatToRawIntBits(hit.v()));
                    assertEquals(Float.intBitsToFloat(expected[4 * i]), hit.t());
                    assertEquals(scene.occluded[i] != 0, tree.occluded(rays.get(i)));
                }
            }
        }
    }

    @Test
    void statusesAreTheLibrarys() {
        Map<String, Integer> ours = new HashMap<>();
        for (Status status : Status.values()) {
            if (status != Status.UNKNOWN) {
                ours.put(status.name(), status.code());
                assertEquals(FILE.statusNames.get(Integer.toString(status.code())), status.words());
                assertEquals(status, Status.of(status.code()));
            }
        }
        assertEquals(FILE.statuses, ours);
        assertEquals(Status.UNKNOWN, Status.of(12345));
    }

    @Test
    void libraryIsTheOneThatWroteTheFile() {
        assertEquals(FILE.library, HTree.libraryVersion());
        assertEquals("0.1.0", HTree.bindingVersion());
    }
}
