// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertNotEquals;
import static org.junit.jupiter.api.Assertions.assertNotNull;
import static org.junit.jupiter.api.Assertions.assertNull;
import static org.junit.jupiter.api.Assertions.assertThrows;
import static org.junit.jupiter.api.Assertions.assertTrue;

import java.lang.ref.WeakReference;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.atomic.AtomicReference;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

/** Trees that rays build, compact and collapsed ones, and trees brought to another mesh. */
@Timeout(300)
class ChangeTest {
    private static final int CELLS = 60;
    private static final Options LAZY = Options.builder(Kind.WIDE).lazy(true).build();
    private static final Options MORTON = Options.builder(Kind.WIDE).morton(true).build();

    private static final Rays RAYS = Fixtures.above(60);

    /** A terrain in direct buffers, lifted more from step to step. */
    private static Mesh terrain(int step) {
        int row = CELLS + 1;
        FloatBuffer positions = ByteBuffer.allocateDirect(12 * row * row)
                .order(ByteOrder.nativeOrder()).asFloatBuffer();
        IntBuffer indices = ByteBuffer.allocateDirect(24 * CELLS * CELLS)
                .order(ByteOrder.nativeOrder()).asIntBuffer();
        for (int i = 0; i < row * row; ++i) {
            float x = (float) (i % row) / CELLS;
            float y = (float) (i / row) / CELLS;
            float z = (float) (0.1 * Math.sin(9 * x) * Math.cos(7 * y));
            positions.put(x).put(y).put(z + 0.1f * step * x);
        }
        for (int i = 0; i < CELLS * CELLS; ++i) {
            int a = i % CELLS + i / CELLS * row;
            indices.put(a).put(a + 1).put(a + row).put(a + 1).put(a + row + 1).put(a + row);
        }
        return Mesh.of(positions.flip(), indices.flip());
    }

    private static int[] hits(HTree tree) {
        return Fixtures.words(tree.intersect(RAYS));
    }

    private static int[] hitsOf(Mesh mesh) {
        try (HTree tree = HTree.build(mesh, Options.of(Kind.BVH_SAH))) {
            return hits(tree);
        }
    }

    private static void assertAnswersAs(HTree tree, Mesh mesh) {
        tree.check();
        assertArrayEquals(hitsOf(mesh), hits(tree));
    }

    private static boolean isCollected(WeakReference<?> reference) throws InterruptedException {
        for (int i = 0; i < 100 && reference.get() != null; ++i) {
            System.gc();
            Thread.sleep(2);
        }
        return reference.get() == null;
    }

    // ---- Compact, collapsed ---------------------------------------------------------------------

    @Test
    void compactTreesAnswerAlikeInLessThanHalfOfTheMemory() {
        Options.Builder how = Options.builder(Kind.WIDE);
        Mesh mesh = terrain(0);
        try (HTree whole = HTree.build(mesh, how.build());
                HTree tree = HTree.build(mesh, how.compact(true).build());
                HTree back = HTree.load(tree.save())) {
            assertTrue(2 * tree.stats().bytes() < whole.stats().bytes());
            HTreeException thrown = assertThrows(HTreeException.class, tree::view);
            assertEquals(Status.UNSUPPORTED, thrown.status());
            assertAnswersAs(tree, mesh);
            assertAnswersAs(back, mesh);
            assertEquals(1, tree.update(terrain(1), How.REFIT));
            assertAnswersAs(tree, terrain(1));
        }
        HTreeException thrown = assertThrows(
                HTreeException.class, () -> HTree.build(mesh, how.lazy(true).build()));
        assertEquals(Status.ARGUMENT, thrown.status());
    }

    @Test
    void collapsedTreesAreWide() {
        Mesh mesh = terrain(0);
        for (Kind kind : new Kind[] {Kind.BVH_MEDIAN, Kind.AH}) {
            Options.Builder how = Options.builder(kind);
            try (HTree plain = HTree.build(mesh, how.build());
                    HTree tree = HTree.build(mesh, how.collapse(true).build())) {
                assertEquals(kind, plain.stats().kind());
                assertEquals(Kind.WIDE, tree.stats().kind());
                assertAnswersAs(tree, mesh);
            }
        }
        try (HTree tree = HTree.build(mesh, Options.of(Kind.BEST))) {
            assertEquals(Kind.WIDE, tree.stats().kind());
        }
    }

    // ---- Lazy ----------------------------------------------------------------------------------

    @Test
    void raysBuildALazyTreeAndCompleteBuildsTheRest() {
        Mesh mesh = terrain(0);
        try (HTree lazy = HTree.build(mesh, LAZY); HTree eager = HTree.build(mesh, MORTON)) {
            long subtrees = lazy.stats().subtrees();
            assertTrue(subtrees > 10);
            assertEquals(0, lazy.stats().subtreesBuilt());
            assertEquals(0, eager.stats().subtrees());
            assertTrue(lazy.intersect(new Ray(0.3f, 0.4f, 2, 0, 0, -1)).isHit());
            long built = lazy.stats().subtreesBuilt();
            assertTrue(0 < built && built < subtrees, built + " of " + subtrees);
            HTreeException thrown = assertThrows(HTreeException.class, lazy::view);
            assertEquals(Status.UNSUPPORTED, thrown.status());
            assertAnswersAs(lazy, mesh);
            lazy.complete();
            lazy.complete();
            assertEquals(0, lazy.stats().subtrees());
            assertEquals(eager.view().nodes(), lazy.view().nodes());
            assertEquals(eager.view().leaves(), lazy.view().leaves());
            assertAnswersAs(lazy, mesh);
        }
    }

    @Test
    void aLazyTreeKeepsItsMeshUntilItIsComplete() throws InterruptedException {
        int[] expected = hitsOf(terrain(0));
        for (boolean completed : new boolean[] {true, false}) {
            Mesh mesh = terrain(0);
            WeakReference<Mesh> kept = new WeakReference<>(mesh);
            HTree tree = HTree.build(mesh, LAZY);
            mesh = null;
            System.gc();
            assertNotNull(kept.get());
            assertArrayEquals(expected, hits(tree));
            if (completed) {
                tree.complete();
            } else {
                tree.close();
            }
            assertTrue(isCollected(kept));
            tree.close();
        }
    }

    @Test
    void anUpdateOfALazyTreeKeepsTheNewMesh() throws InterruptedException {
        Mesh mesh = terrain(0);
        Mesh next = terrain(1);
        WeakReference<Mesh> kept = new WeakReference<>(mesh);
        WeakReference<Mesh> keptNext = new WeakReference<>(next);
        try (HTree tree = HTree.build(mesh, LAZY)) {
            mesh = null;
            Mesh bad = Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4});
            assertThrows(HTreeException.class, () -> tree.update(bad, How.REBUILD));
            System.gc();
            assertNotNull(kept.get());
            assertEquals(1, tree.update(next, How.REFIT));
            next = null;
            assertTrue(isCollected(kept));
            assertNotNull(keptNext.get());
            assertTrue(tree.stats().subtrees() > 10);
            assertAnswersAs(tree, terrain(1));
            tree.complete();
            assertTrue(isCollected(keptNext));
        }
    }

    @Test
    void threadsMeetInALazyTree() throws InterruptedException {
        Mesh mesh = terrain(0);
        int[] expected = hitsOf(mesh);
        for (int round = 0; round < 20; ++round) {
            try (HTree tree = HTree.build(mesh, LAZY)) {
                inThreads(4, () -> assertArrayEquals(expected, hits(tree)), tree::complete);
            }
        }
    }

    /** Runs work in some threads, and other work in this one meanwhile. */
    private static void inThreads(int count, Runnable work, Runnable here)
            throws InterruptedException {
        AtomicReference<Throwable> failure = new AtomicReference<>();
        List<Thread> threads = new ArrayList<>();
        for (int i = 0; i < count; ++i) {
            Thread thread = new Thread(work);
            thread.setUncaughtExceptionHandler((t, thrown) -> failure.set(thrown));
            thread.start();
            threads.add(thread);
        }
        here.run();
        for (Thread thread : threads) {
            thread.join();
        }
        assertNull(failure.get());
    }

    // ---- Update --------------------------------------------------------------------------------

    @Test
    void everyKindAnswersAsANewTree() {
        for (Kind kind : Kind.values()) {
            try (HTree tree = HTree.build(Mesh.builder().build(), Options.of(kind))) {
                How[] ways = {How.REBUILD, How.REFIT, How.REFIT, How.REBUILD};
                for (int step = 0; step < ways.length; ++step) {
                    double quality = tree.update(terrain(step), ways[step]);
                    assertTrue(quality > 0.2 && quality < 20, kind + ": " + quality);
                    assertTrue(ways[step] == How.REFIT || quality == 1);
                    assertAnswersAs(tree, terrain(step));
                }
            }
        }
    }

    @Test
    void refittingIsNoRebuild() {
        try (HTree tree = HTree.build(terrain(0)); HTree fresh = HTree.build(terrain(5))) {
            assertEquals(1, tree.update(terrain(0), How.REFIT), 1e-9);
            assertNotEquals(1, tree.update(terrain(5), How.REFIT), 1e-9);
            assertNotEquals(fresh.view().nodes(), tree.view().nodes());
            assertEquals(1, tree.update(terrain(5), How.REBUILD));
            assertEquals(fresh.view().nodes(), tree.view().nodes());
        }
    }

    @Test
    void whatIsRefusedLeavesTheTreeAsItWas() {
        Mesh mesh = terrain(0);
        Mesh bad = Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4});
        try (HTree tree = HTree.build(mesh)) {
            for (How how : How.values()) {
                HTreeException thrown =
                        assertThrows(HTreeException.class, () -> tree.update(bad, how));
                assertEquals(Status.GEOMETRY, thrown.status());
                assertAnswersAs(tree, mesh);
            }
            assertThrows(NullPointerException.class, () -> tree.update(mesh, null));
            assertThrows(NullPointerException.class, () -> tree.update(null, How.REFIT));
            assertAnswersAs(tree, mesh);
        }
    }

    private static Mesh objectsAt(float t) {
        return Mesh.builder().objects(UserObjects.of(
                new float[] {-1, -1, -1, 1, 1, 1}, (object, ray) -> new Hit(t, 0, 0))).build();
    }

    @Test
    void objectsAreThoseOfTheLastUpdate() {
        Ray ray = new Ray(0, 0, 3, 0, 0, -1);
        try (HTree tree = HTree.build(objectsAt(2))) {
            for (How how : How.values()) {
                float t = 2.25f + 0.25f * how.ordinal();
                tree.update(objectsAt(t), how);
                System.gc();
                assertEquals(t, tree.intersect(ray).t());
            }
            tree.update(Mesh.builder().build(), How.REBUILD);
            assertTrue(!tree.intersect(ray).isHit());
        }
    }

    // ---- One at a time -------------------------------------------------------------------------

    @Test
    void updatesAndQueriesWaitForEachOther() throws InterruptedException {
        Mesh[] forms = {terrain(0), terrain(1)};
        int[][] expected = {hitsOf(forms[0]), hitsOf(forms[1])};
        AtomicBoolean done = new AtomicBoolean();
        try (HTree tree = HTree.build(forms[0])) {
            inThreads(3, () -> {
                while (!done.get()) {
                    int[] hits = hits(tree);
                    assertTrue(Arrays.stream(expected).anyMatch(one -> Arrays.equals(hits, one)));
                    Thread.yield();
                }
            }, () -> {
                for (int i = 1; i < 100; ++i) {
                    tree.update(forms[i % 2], How.values()[i / 2 % 2]);
                }
                done.set(true);
            });
            assertArrayEquals(expected[1], hits(tree));
        }
    }

    @Test
    void callbacksCannotChangeTheTreeThatTheyServe() {
        Mesh mesh = terrain(0);
        try (HTree tree = HTree.build(mesh)) {
            for (Runnable change : new Runnable[] {
                tree::complete, () -> tree.update(mesh, How.REFIT)}) {
                Query query = Query.DEFAULT.withThreads(1).withProgress(fraction -> {
                    change.run();
                    return false;
                });
                IllegalStateException thrown = assertThrows(IllegalStateException.class,
                        () -> tree.intersect(RAYS, Hits.allocate(RAYS.count()), query));
                assertTrue(thrown.getMessage().contains("callback"), thrown.getMessage());
                change.run();
            }
        }
    }
}
