// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertSame;
import static org.junit.jupiter.api.Assertions.assertThrows;
import static org.junit.jupiter.api.Assertions.assertTrue;

import java.nio.FloatBuffer;
import java.util.ArrayList;
import java.util.List;
import java.util.Set;
import java.util.concurrent.ConcurrentHashMap;
import org.junit.jupiter.api.Test;

/** Progress and objects: Java called from C, and what it throws on the way back. */
class CallbackTest {
    private static final int SPHERES = 40;
    private static final float RADIUS = 0.02f;

    private static float centre(int object) {
        return (object + 0.5f) / SPHERES;
    }

    /** Spheres stand along the diagonal of the unit square, at height 1. */
    private static Hit intersectSphere(int object, Ray ray) {
        double x = ray.orgX() - centre(object);
        double y = ray.orgY() - centre(object);
        double z = ray.orgZ() - 1;
        double a = ray.dirX() * ray.dirX() + ray.dirY() * ray.dirY() + ray.dirZ() * ray.dirZ();
        double b = x * ray.dirX() + y * ray.dirY() + z * ray.dirZ();
        double discriminant = b * b - a * (x * x + y * y + z * z - RADIUS * RADIUS);
        if (discriminant < 0) {
            return null;
        }
        return new Hit((float) ((-b - Math.sqrt(discriminant)) / a), 0.25f, 0.75f);
    }

    /** One large triangle below the spheres. */
    private static Mesh spheres(ObjectIntersector intersector) {
        float[] boxes = new float[6 * SPHERES];
        for (int i = 0; i < SPHERES; ++i) {
            for (int axis = 0; axis < 3; ++axis) {
                float middle = axis == 2 ? 1 : centre(i);
                boxes[6 * i + axis] = middle - 1.01f * RADIUS;
                boxes[6 * i + 3 + axis] = middle + 1.01f * RADIUS;
            }
        }
        return Mesh.builder()
                .positions(FloatBuffer.wrap(new float[] {-5, -5, 0, 9, -5, 0, -5, 9, 0}))
                .objects(UserObjects.of(boxes, intersector)).build();
    }

    private static Hits down(HTree tree, int threads) {
        Rays rays = Rays.allocate(100 * SPHERES);
        for (int i = 0; i < rays.count(); ++i) {
            rays.set(i, new Ray(centre(i % SPHERES), centre(i % SPHERES), 3, 0, 0, -1));
        }
        Hits hits = Hits.allocate(rays.count());
        tree.intersect(rays, hits, Query.DEFAULT.withThreads(threads));
        return hits;
    }

    @Test
    void objectsAreHitOnAnyThreads() {
        Set<Thread> threads = ConcurrentHashMap.newKeySet();
        Mesh mesh = spheres((object, ray) -> {
            threads.add(Thread.currentThread());
            return intersectSphere(object, ray);
        });
        try (HTree tree = HTree.build(mesh)) {
            Hits hits = down(tree, 1);
            assertEquals(Set.of(Thread.currentThread()), threads);
            for (int i = 0; i < hits.count(); ++i) {
                assertEquals(1 + i % SPHERES, hits.prim(i));
                assertEquals(2 - RADIUS, hits.t(i), 1e-6);
                assertEquals(0.25f, hits.u(i));
                assertEquals(0.75f, hits.v(i));
            }
            assertArrayEquals(Fixtures.words(hits), Fixtures.words(down(tree, 4)));
            assertEquals(SPHERES, tree.stats().objects());
            assertEquals(0, tree.intersect(new Ray(0, 0.5f, 3, 0, 0, -1)).prim());
        }
    }

    @Test
    void missedObjectsShowTheTriangle() {
        try (HTree tree = HTree.build(spheres((object, ray) -> null))) {
            Hits hits = down(tree, 1);
            for (int i = 0; i < hits.count(); ++i) {
                assertEquals(0, hits.prim(i));
            }
        }
    }

    @Test
    void whatAnIntersectorThrowsLeavesTheQuery() {
        IllegalStateException broken = new IllegalStateException("broken sphere");
        Mesh mesh = spheres((object, ray) -> {
            if (object == 7) {
                throw broken;
            }
            return intersectSphere(object, ray);
        });
        try (HTree tree = HTree.build(mesh)) {
            assertSame(broken, assertThrows(IllegalStateException.class, () -> down(tree, 1)));
            assertSame(broken, assertThrows(IllegalStateException.class, () -> down(tree, 4)));
            Ray ray = new Ray(centre(3), centre(3), 3, 0, 0, -1);
            assertEquals(4, tree.intersect(ray).prim());
        }
    }

    @Test
    void treeMayBeClosedByItsOwnIntersector() {
        HTree[] tree = new HTree[1];
        tree[0] = HTree.build(spheres((object, ray) -> {
            tree[0].close();
            return intersectSphere(object, ray);
        }));
        Hits hits = down(tree[0], 1);
        assertEquals(1, hits.prim(0));
        assertTrue(tree[0].isClosed());
        assertThrows(IllegalStateException.class, () -> down(tree[0], 1));
    }

    @Test
    void treesMayBeQueriedByIntersectors() {
        try (HTree inner = HTree.build(spheres(CallbackTest::intersectSphere));
                HTree outer = HTree.build(spheres((object, ray) -> inner.intersect(ray)))) {
            assertEquals(2 - RADIUS, outer.intersect(
                    new Ray(centre(5), centre(5), 3, 0, 0, -1)).t(), 1e-6);
        }
    }

    @Test
    void progressRisesOnTheCallersThread() {
        List<Double> reports = new ArrayList<>();
        Set<Thread> threads = ConcurrentHashMap.newKeySet();
        Progress progress = fraction -> {
            threads.add(Thread.currentThread());
            reports.add(fraction);
            return false;
        };
        Options options = Options.builder(Kind.H).progress(progress).build();
        try (HTree tree = HTree.build(Fixtures.terrain(60), options)) {
            assertRising(reports);
            reports.clear();
            Rays rays = Fixtures.above(150);
            tree.intersect(rays, Hits.allocate(rays.count()), onThisThread(progress));
            assertRising(reports);
        }
        assertEquals(Set.of(Thread.currentThread()), threads);
    }

    /** With helpers, a late caller may find all work done and hear nothing. */
    private static Query onThisThread(Progress progress) {
        return Query.DEFAULT.withThreads(1).withProgress(progress);
    }

    private static void assertRising(List<Double> reports) {
        assertTrue(reports.size() > 3, "only " + reports);
        double before = 0;
        for (double fraction : reports) {
            assertTrue(before <= fraction && fraction <= 1, reports.toString());
            before = fraction;
        }
    }

    @Test
    void whatProgressThrowsLeavesTheCall() {
        ArithmeticException broken = new ArithmeticException("broken bar");
        Progress progress = fraction -> {
            throw broken;
        };
        Options options = Options.builder(Kind.H).progress(progress).build();
        long live = Handle.live();
        assertSame(broken, assertThrows(ArithmeticException.class,
                () -> HTree.build(Fixtures.terrain(60), options)));
        try (HTree tree = HTree.build(Fixtures.terrain(60))) {
            Rays rays = Fixtures.above(150);
            assertSame(broken, assertThrows(ArithmeticException.class, () -> tree.intersect(
                    rays, Hits.allocate(rays.count()), onThisThread(progress))));
        }
        assertEquals(live, Handle.live());
    }
}
