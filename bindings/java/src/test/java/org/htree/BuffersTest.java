// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertThrows;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import org.junit.jupiter.api.AfterEach;
import org.junit.jupiter.api.Test;

/** Direct buffers are used where they lie, others copied or refused; nothing outside is touched. */
class BuffersTest {
    private final HTree tree = HTree.build(Fixtures.terrain(20));
    private final Rays rays = Fixtures.above(16);
    private final int[] expected = Fixtures.words(tree.intersect(rays));

    @AfterEach
    void closeTree() {
        tree.close();
    }

    private static ByteBuffer direct(int bytes) {
        return ByteBuffer.allocateDirect(bytes).order(ByteOrder.nativeOrder());
    }

    @Test
    void wrappedRaysAreNotCopied() {
        FloatBuffer memory = direct(64).asFloatBuffer();
        Rays wrapped = Rays.wrap(memory);
        assertEquals(2, wrapped.count());
        memory.put(8, 42);
        assertEquals(42, wrapped.get(1).orgX());
        wrapped.set(0, new Ray(7, 0, 0, 0, 0, 1));
        assertEquals(7, memory.get(0));
        assertEquals(Float.POSITIVE_INFINITY, memory.get(7));
    }

    @Test
    void onlyWhatLiesBetweenPositionAndLimitIsUsed() {
        ByteBuffer memory = direct(16 * (rays.count() + 2));
        for (int i = 0; i < memory.capacity(); ++i) {
            memory.put(i, (byte) 0x5a);
        }
        FloatBuffer shifted = direct(32 * (rays.count() + 1)).asFloatBuffer();
        shifted.position(8).put(rays.buffer()).position(8);
        Hits hits = Hits.wrap(memory.position(16).limit(memory.capacity() - 16));
        tree.intersect(Rays.wrap(shifted), hits, null);
        assertArrayEquals(expected, Fixtures.words(hits));
        for (int i = 0; i < 16; ++i) {
            assertEquals(0x5a, memory.clear().get(i));
            assertEquals(0x5a, memory.get(memory.capacity() - 1 - i));
        }
    }

    @Test
    void occludedStaysWithinItsBuffer() {
        ByteBuffer memory = direct(rays.count() + 2);
        memory.put(0, (byte) 9).put(rays.count() + 1, (byte) 9);
        tree.occluded(rays, memory.slice(1, rays.count()), null);
        assertEquals(9, memory.get(0));
        assertEquals(9, memory.get(rays.count() + 1));
        for (int i = 0; i < rays.count(); ++i) {
            assertEquals(expected[4 * i + 3] == Hit.NONE ? 0 : 1, memory.get(1 + i));
        }
    }

    @Test
    void meshMayLieInAnyBuffer() {
        FloatBuffer heap = FloatBuffer.wrap(Fixtures.TETRAHEDRON);
        FloatBuffer swapped = ByteBuffer.allocateDirect(48)
                .order(ByteOrder.nativeOrder() == ByteOrder.BIG_ENDIAN
                        ? ByteOrder.LITTLE_ENDIAN : ByteOrder.BIG_ENDIAN)
                .asFloatBuffer().put(Fixtures.TETRAHEDRON).flip();
        FloatBuffer odd = direct(49).slice(1, 48).order(ByteOrder.nativeOrder()).asFloatBuffer()
                .put(Fixtures.TETRAHEDRON).flip();
        IntBuffer faces = IntBuffer.wrap(Fixtures.TETRAHEDRON_FACES);
        Ray ray = new Ray(2, 2, 2, -1, -1, -1);
        for (FloatBuffer positions : new FloatBuffer[] {heap, swapped, odd}) {
            try (HTree small = HTree.build(Mesh.of(positions, faces))) {
                assertEquals(3, small.intersect(ray).prim());
            }
            assertEquals(0, positions.position());
        }
        assertEquals(0, faces.position());
    }

    @Test
    void raysThatCCannotReadAreRefused() {
        assertThrows(IllegalArgumentException.class, () -> Rays.wrap(FloatBuffer.allocate(8)));
        assertThrows(IllegalArgumentException.class, () -> Rays.wrap(
                ByteBuffer.allocateDirect(32).order(ByteOrder.BIG_ENDIAN).asFloatBuffer()));
        assertThrows(IllegalArgumentException.class, () -> Rays.wrap(
                direct(33).slice(1, 32).order(ByteOrder.nativeOrder()).asFloatBuffer()));
        assertThrows(IllegalArgumentException.class, () -> Rays.wrap(direct(36).asFloatBuffer()));
    }

    @Test
    void answersThatCCannotWriteAreRefused() {
        assertThrows(IllegalArgumentException.class, () -> Hits.wrap(ByteBuffer.allocate(16)));
        assertThrows(IllegalArgumentException.class,
                () -> Hits.wrap(direct(16).asReadOnlyBuffer()));
        assertThrows(IllegalArgumentException.class, () -> Hits.wrap(direct(17).slice(1, 16)));
        assertThrows(IllegalArgumentException.class, () -> Hits.wrap(direct(17)));
        assertThrows(IllegalArgumentException.class,
                () -> tree.occluded(rays, direct(rays.count()).asReadOnlyBuffer(), null));
    }

    @Test
    void roomForTooFewAnswersIsRefused() {
        int few = rays.count() - 1;
        Hits hits = Hits.allocate(rays.count());
        assertThrows(IllegalArgumentException.class,
                () -> tree.intersect(rays, Hits.allocate(few), null));
        assertThrows(IllegalArgumentException.class, () -> tree.occluded(rays, direct(few), null));
        assertThrows(IllegalArgumentException.class, () -> tree.intersect(rays, hits,
                Query.DEFAULT.withCounters(Counters.allocate(few))));
        assertThrows(IllegalArgumentException.class, () -> tree.intersect(rays, hits,
                Query.DEFAULT.withThreads(-1)));
        assertThrows(IllegalArgumentException.class, () -> Hits.allocate(-1));
        assertThrows(IllegalArgumentException.class, () -> Hits.allocate(1 << 27));
    }

    @Test
    void indicesBeyondTheBatchAreRefused() {
        Hits hits = Hits.allocate(2);
        assertThrows(IndexOutOfBoundsException.class, () -> hits.t(2));
        assertThrows(IndexOutOfBoundsException.class, () -> hits.prim(-1));
        assertThrows(IndexOutOfBoundsException.class, () -> rays.get(rays.count()));
        assertThrows(IndexOutOfBoundsException.class, () -> Counters.allocate(1).leafSteps(1));
    }
}
