// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertFalse;
import static org.junit.jupiter.api.Assertions.assertNotEquals;
import static org.junit.jupiter.api.Assertions.assertThrows;
import static org.junit.jupiter.api.Assertions.assertTrue;

import java.nio.FloatBuffer;
import org.junit.jupiter.api.Test;

/** What a tree answers, and what the classes around it hold. */
class HTreeTest {
    private static final Ray INTO_FACE_3 = new Ray(2, 2, 2, -1, -1, -1);

    @Test
    void rayHitsTheTetrahedron() {
        try (HTree tree = HTree.build(Fixtures.tetrahedron())) {
            Hit hit = tree.intersect(INTO_FACE_3);
            assertTrue(hit.isHit());
            assertEquals(3, hit.prim());
            assertEquals(5f / 3, hit.t(), 1e-6);
            assertTrue(tree.occluded(INTO_FACE_3));
            assertEquals(new Box(0, 0, 0, 1, 1, 1), tree.bounds());
            assertEquals(4, tree.stats().triangles());
            assertTrue(tree.stats().buildSeconds() >= 0);
        }
    }

    @Test
    void missKeepsTmax() {
        try (HTree tree = HTree.build(Fixtures.tetrahedron())) {
            Hit miss = tree.intersect(new Ray(2, 2, 2, 0, 1, 1, 1, 7));
            assertEquals(new Hit(7, 0, 0, Hit.NONE), miss);
            assertFalse(miss.isHit());
        }
    }

    @Test
    void emptyMeshIsMissed() {
        try (HTree tree = HTree.build(Mesh.builder().build())) {
            assertFalse(tree.intersect(INTO_FACE_3).isHit());
            assertTrue(tree.bounds().isEmpty());
            assertEquals(0, tree.intersect(Rays.allocate(0)).count());
        }
    }

    @Test
    void verticesMayLieAmongOtherData() {
        float[] interleaved = new float[5 * 4];
        for (int i = 0; i < 4; ++i) {
            System.arraycopy(Fixtures.TETRAHEDRON, 3 * i, interleaved, 5 * i, 3);
        }
        Mesh mesh = Mesh.builder().positions(FloatBuffer.wrap(interleaved), 20)
                .indices(Fixtures.ints(Fixtures.TETRAHEDRON_FACES)).build();
        assertEquals(4, mesh.vertexCount());
        try (HTree tree = HTree.build(mesh); HTree plain = HTree.build(Fixtures.tetrahedron())) {
            assertEquals(plain.intersect(INTO_FACE_3), tree.intersect(INTO_FACE_3));
        }
    }

    @Test
    void everyKindHasItsNameAndNumber() {
        for (Kind kind : Kind.values()) {
            assertEquals(kind, Kind.fromLabel(kind.label()));
            assertEquals(kind, Kind.of(kind.code()));
        }
        assertEquals("bvh-sah", Kind.BVH_SAH.label());
        assertThrows(IllegalArgumentException.class, () -> Kind.fromLabel("octree"));
        assertThrows(IllegalArgumentException.class, () -> Kind.fromLabel(null));
        assertThrows(IllegalArgumentException.class, () -> Kind.of(99));
    }

    @Test
    void defaultsAreTheLibrarys() {
        Options options = Options.of(Kind.BEST);
        assertEquals(Kind.BVH_SAH, options.kind());
        assertTrue(options.collapse());
        assertEquals(32, options.buckets());
        assertEquals(1.2f, options.costBv6());
        assertEquals(options, options.toBuilder().build());
        assertTrue(Options.of(Kind.FAST).morton());
        assertNotEquals(options, options.toBuilder().strict(true).build());
    }

    @Test
    void everyOptionReachesTheLibrary() {
        Mesh mesh = Fixtures.terrain(40);
        Rays rays = Fixtures.above(20);
        Options odd = Options.builder(Kind.AH).threads(1).buckets(5).axes(3).anyPlanes(true)
                .loosePlanes(true).strict(true).costs(1, 2, 3, 4).cellsPerPrim(2).fewPrims(1)
                .build();
        try (HTree tree = HTree.build(mesh, odd); HTree plain = HTree.build(mesh)) {
            tree.check();
            assertEquals(Kind.AH, tree.stats().kind());
            assertNotEquals(plain.stats().sahCost(), tree.stats().sahCost());
            assertArrayEquals(
                    Fixtures.words(plain.intersect(rays)), Fixtures.words(tree.intersect(rays)));
        }
        assertThrows(IllegalArgumentException.class,
                () -> HTree.build(mesh, Options.builder(Kind.H).threads(-1).build()));
    }

    @Test
    void calibrationMeasuresCosts() {
        Options measured = Options.of(Kind.H).calibrated();
        assertEquals(1, measured.costSkd());
        assertTrue(measured.costBv6() > 0 && measured.costIntersect() > 0);
        HTree.build(Fixtures.tetrahedron(), measured).close();
    }

    @Test
    void countersCountAndChangeNothing() {
        Rays rays = Fixtures.above(30);
        Hits hits = Hits.allocate(rays.count());
        Counters counters = Counters.allocate(rays.count());
        try (HTree tree = HTree.build(Fixtures.terrain(30))) {
            tree.intersect(rays, hits, Query.DEFAULT.withThreads(2).withCounters(counters));
            assertArrayEquals(Fixtures.words(tree.intersect(rays)), Fixtures.words(hits));
        }
        int tests = 0;
        for (int i = 0; i < rays.count(); ++i) {
            assertTrue(counters.leafSteps(i) <= counters.traversalSteps(i));
            assertTrue(!hits.isHit(i) || counters.intersections(i) > 0);
            tests += counters.intersections(i);
        }
        assertTrue(tests > rays.count() / 2);
    }

    @Test
    void viewIsACopyThatOutlivesTheTree() {
        HTree tree = HTree.build(Fixtures.tetrahedron(), Options.of(Kind.H));
        View view = tree.view();
        tree.close();
        assertEquals(Kind.H, view.kind());
        assertEquals(4, view.triangleCount());
        assertEquals(4, view.prims());
        assertEquals(0, view.objectCount());
        assertEquals(new Box(0, 0, 0, 1, 1, 1), view.bounds());
        assertEquals(36, view.triangles().capacity());
        for (int i = 0; i < 12; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                assertEquals(Fixtures.TETRAHEDRON[3 * Fixtures.TETRAHEDRON_FACES[i] + axis],
                        view.triangles().get(3 * i + axis));
            }
        }
        assertTrue(view.nodes().capacity() > 0 && view.nodes().isReadOnly());
        assertEquals(0, view.grid().capacity());
    }

    @Test
    void gridHasItsArrays() {
        try (HTree tree = HTree.build(Fixtures.terrain(8), Options.of(Kind.UG))) {
            View view = tree.view();
            assertTrue(view.grid().capacity() > 0 && view.leaves().capacity() > 0);
        }
    }

    @Test
    void wideLeavesHoldTheTriangles() {
        try (HTree tree = HTree.build(Fixtures.tetrahedron())) {
            View view = tree.view();
            assertEquals(Kind.WIDE, view.kind());
            assertEquals(4, view.triangleCount());
            assertEquals(0, view.triangles().capacity());
            assertTrue(view.leaves().capacity() > 0);
        }
    }

    @Test
    void exceptionSaysWhatWasWrong() {
        HTreeException thrown = assertThrows(HTreeException.class,
                () -> HTree.build(Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4})));
        assertEquals("triangle 0 refers to vertex 4 of 4", thrown.getMessage());
        assertTrue(thrown.toString().contains("GEOMETRY (4)"), thrown.toString());
    }

    @Test
    void arraysOfBrokenLengthAreRefused() {
        assertThrows(IllegalArgumentException.class, () -> Mesh.of(new float[4], new int[0]));
        assertThrows(IllegalArgumentException.class, () -> Mesh.of(new float[3], new int[2]));
        assertThrows(IllegalArgumentException.class, () -> Rays.copyOf(new float[9]));
        assertThrows(IllegalArgumentException.class,
                () -> UserObjects.of(new float[5], (object, ray) -> null));
        assertThrows(IllegalArgumentException.class, () -> Mesh.builder()
                .triangleCount(3).indices(Fixtures.ints(0, 0, 0)).build());
        assertThrows(IllegalArgumentException.class,
                () -> Mesh.builder().positions(FloatBuffer.allocate(9), -4));
        assertThrows(NullPointerException.class, () -> HTree.build(null));
    }
}
