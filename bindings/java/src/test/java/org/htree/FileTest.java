// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertArrayEquals;
import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertThrows;

import java.nio.ByteBuffer;
import org.junit.jupiter.api.Test;

/** A tree that is saved and loaded is the same tree, and what is no tree is not loaded. */
class FileTest {
    private static final ObjectIntersector TOP =
            (object, ray) -> new Hit((1 - ray.orgZ()) / ray.dirZ(), 0, object, 0);

    private static void assertStatus(Status status, ByteBuffer file) {
        HTreeException why = assertThrows(HTreeException.class, () -> HTree.load(file).close());
        assertEquals(status, why.status());
    }

    @Test
    void savedTreeComesBack() {
        Rays rays = Fixtures.above(40);
        for (Kind kind : Kind.values()) {
            try (HTree tree = HTree.build(Fixtures.terrain(20), Options.of(kind))) {
                ByteBuffer file = tree.save();
                byte[] bytes = new byte[file.remaining() + 5];
                file.duplicate().get(bytes, 5, file.remaining());
                for (ByteBuffer from : new ByteBuffer[] {
                    file, file.asReadOnlyBuffer(), ByteBuffer.wrap(bytes, 5, bytes.length - 5)}) {
                    try (HTree back = HTree.load(from, 1, null)) {
                        assertEquals(tree.stats().kind(), back.stats().kind());
                        assertEquals(file, back.save());
                        assertArrayEquals(Fixtures.words(tree.intersect(rays)),
                                Fixtures.words(back.intersect(rays)));
                        back.check();
                    }
                }
            }
        }
    }

    @Test
    void objectsNeedTheirIntersectorAgain() {
        float[] boxes = {0, 0, 0, 1, 1, 1, 2, 0, 0, 3, 1, 1};
        Mesh mesh = Mesh.builder().objects(UserObjects.of(boxes, TOP)).build();
        ByteBuffer file;
        try (HTree tree = HTree.build(mesh)) {
            file = tree.save();
        }
        assertStatus(Status.ARGUMENT, file);
        try (HTree back = HTree.load(file, 0, TOP)) {
            assertEquals(new Hit(4, 0, 1, 1), back.intersect(new Ray(2.5f, .5f, 5, 0, 0, -1)));
        }
        assertThrows(IllegalArgumentException.class, () -> HTree.load(file, -1, TOP));
    }

    @Test
    void whatIsNoTreeIsNotLoaded() {
        HTree tree = HTree.build(Fixtures.tetrahedron());
        ByteBuffer file = tree.save();
        tree.close();
        assertThrows(IllegalStateException.class, tree::save);
        assertStatus(Status.CORRUPT, ByteBuffer.allocate(0));
        assertStatus(Status.CORRUPT, file.duplicate().limit(100));
        assertStatus(Status.CORRUPT, file.duplicate().limit(file.capacity() - 1));
        file.put(file.capacity() / 2, (byte) ~file.get(file.capacity() / 2));
        assertStatus(Status.CORRUPT, file);
        assertThrows(NullPointerException.class, () -> HTree.load(null));
    }
}
