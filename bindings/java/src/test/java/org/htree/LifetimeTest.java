// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertFalse;
import static org.junit.jupiter.api.Assertions.assertNull;
import static org.junit.jupiter.api.Assertions.assertThrows;
import static org.junit.jupiter.api.Assertions.assertTrue;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collections;
import java.util.List;
import java.util.Random;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicReference;
import org.junit.jupiter.api.BeforeEach;
import org.junit.jupiter.api.Test;
import org.junit.jupiter.api.Timeout;

/** Trees are freed once, at the right moment, in whatever order they are let go. */
@Timeout(300)
class LifetimeTest {
    private static final int MANY = 100_000;
    private static final long GROWTH_BYTES = 64 << 20;

    private long before;

    @BeforeEach
    void countTrees() throws InterruptedException {
        before = collect(0);
    }

    /** Trees that live after the garbage collector had its chances to get them down to a number. */
    private static long collect(long wanted) throws InterruptedException {
        for (int i = 0; i < 100 && Handle.live() > wanted; ++i) {
            System.gc();
            Thread.sleep(10);
        }
        return Handle.live();
    }

    @Test
    void closingTwiceDoesNothing() {
        HTree tree = HTree.build(Fixtures.tetrahedron());
        assertFalse(tree.isClosed());
        assertEquals(before + 1, Handle.live());
        tree.close();
        tree.close();
        assertTrue(tree.isClosed());
        assertEquals(before, Handle.live());
    }

    @Test
    void everyUseAfterCloseThrows() {
        HTree tree = HTree.build(Fixtures.tetrahedron());
        tree.close();
        Ray ray = new Ray(2, 2, 2, -1, -1, -1);
        for (Runnable use : new Runnable[] {
            () -> tree.intersect(ray), () -> tree.intersect(Rays.of(ray)),
            () -> tree.intersect(Rays.of(ray), Hits.allocate(1), Query.DEFAULT),
            () -> tree.occluded(ray), () -> tree.occluded(Rays.of(ray)),
            tree::bounds, tree::stats, tree::view, tree::check, tree::complete,
            () -> tree.update(Fixtures.tetrahedron(), How.REFIT)}) {
            assertThrows(IllegalStateException.class, use::run);
        }
    }

    @Test
    void treesCloseInAnyOrder() {
        for (int round = 0; round < 20; ++round) {
            List<HTree> trees = new ArrayList<>();
            for (int i = 0; i < 20; ++i) {
                trees.add(HTree.build(Fixtures.tetrahedron()));
            }
            Collections.shuffle(trees, new Random(round));
            trees.forEach(HTree::close);
        }
        assertEquals(before, Handle.live());
    }

    @Test
    void meshAndOptionsMayGoBeforeTheTree() throws InterruptedException {
        HTree tree = buildFromGarbage();
        collect(0);
        for (int i = 0; i < 200; ++i) {
            ByteBuffer.allocateDirect(1 << 16);
        }
        assertEquals(0.5f, tree.intersect(new Ray(0, 0, 0, 0, 0, 1)).t());
        tree.close();
    }

    private static HTree buildFromGarbage() {
        return HTree.build(Mesh.builder().objects(UserObjects.of(
                new float[] {-1, -1, 0, 1, 1, 1}, (object, ray) -> new Hit(0.5f, 0, 0))).build());
    }

    @Test
    void failedBuildsLeaveNothing() {
        for (int i = 0; i < 1000; ++i) {
            assertThrows(HTreeException.class,
                    () -> HTree.build(Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4})));
        }
        assertEquals(before, Handle.live());
    }

    @Test
    void forgottenTreesAreFreed() throws InterruptedException {
        Mesh mesh = Fixtures.tetrahedron();
        for (int i = 0; i < 1000; ++i) {
            HTree.build(mesh);
        }
        assertEquals(before, collect(before));
    }

    @Test
    void manyForgottenTreesDoNotGrowTheProcess() throws IOException, InterruptedException {
        Mesh mesh = Fixtures.tetrahedron();
        forget(mesh, MANY);
        collect(before);
        long settled = residentBytes();
        forget(mesh, MANY);
        assertEquals(before, collect(before));
        long growth = residentBytes() - settled;
        assertTrue(growth < GROWTH_BYTES, "grew by " + growth + " bytes");
    }

    /** Collects often, so that what is measured is not how long the collector waits. */
    private static void forget(Mesh mesh, int count) {
        Options options = Options.of(Kind.H);
        for (int i = 0; i < count; ++i) {
            HTree.build(mesh, options);
            if (i % 2000 == 0) {
                System.gc();
            }
        }
    }

    private static long residentBytes() throws IOException {
        String[] pages = Files.readString(Path.of("/proc/self/statm")).split(" ");
        return Long.parseLong(pages[1]) * 4096;
    }

    @Test
    void closingWhileOthersQueryIsSafe() throws InterruptedException {
        Rays rays = Fixtures.above(60);
        Mesh mesh = Fixtures.terrain(20);
        int[] expected;
        try (HTree tree = HTree.build(mesh)) {
            expected = Fixtures.words(tree.intersect(rays));
        }
        AtomicInteger finished = new AtomicInteger();
        AtomicReference<Throwable> failure = new AtomicReference<>();
        for (int round = 0; round < 100; ++round) {
            HTree tree = HTree.build(mesh);
            List<Thread> threads = new ArrayList<>();
            for (int i = 0; i < 4; ++i) {
                Thread thread = new Thread(() -> queryUntilClosed(tree, rays, expected, finished));
                thread.setUncaughtExceptionHandler((t, thrown) -> failure.set(thrown));
                thread.start();
                threads.add(thread);
            }
            Thread.sleep(round % 5);
            tree.close();
            for (Thread thread : threads) {
                thread.join();
            }
            assertNull(failure.get());
            assertEquals(before, Handle.live());
        }
        assertTrue(finished.get() > 100, finished + " queries finished");
    }

    private static void queryUntilClosed(
            HTree tree, Rays rays, int[] expected, AtomicInteger finished) {
        while (true) {
            Hits hits;
            try {
                hits = tree.intersect(rays);
            } catch (IllegalStateException closed) {
                return;
            }
            assertArrayEquals(expected, Fixtures.words(hits));
            finished.incrementAndGet();
        }
    }

    @Test
    void threadsShareATree() throws InterruptedException {
        Rays rays = Fixtures.above(40);
        AtomicReference<Throwable> failure = new AtomicReference<>();
        try (HTree tree = HTree.build(Fixtures.terrain(20), Options.of(Kind.FAST))) {
            int[] expected = Fixtures.words(tree.intersect(rays));
            List<Thread> threads = new ArrayList<>();
            for (int i = 0; i < 8; ++i) {
                Thread thread = new Thread(() -> {
                    for (int j = 0; j < 50; ++j) {
                        assertArrayEquals(expected, Fixtures.words(tree.intersect(rays)));
                        assertThrows(HTreeException.class, () -> HTree.build(
                                Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4})));
                    }
                });
                thread.setUncaughtExceptionHandler((t, thrown) -> failure.set(thrown));
                thread.start();
                threads.add(thread);
            }
            for (Thread thread : threads) {
                thread.join();
            }
        }
        assertNull(failure.get());
    }
}
