// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.FloatBuffer;
import java.util.Objects;
import org.htree.raw.Structs;

/** Objects of your own (spheres, cones, ...), known by box and callback. */
public final class UserObjects {
    private static final int FLOATS = 6;

    private final FloatBuffer boxes;
    private final ObjectIntersector intersector;

    private UserObjects(FloatBuffer boxes, ObjectIntersector intersector) {
        if (boxes.remaining() % FLOATS != 0) {
            throw new IllegalArgumentException(boxes.remaining() + " floats: a box has " + FLOATS);
        }
        this.boxes = Direct.of(boxes);
        this.intersector = Objects.requireNonNull(intersector, "intersector");
    }

    /**
     * Objects in boxes that contain them.
     *
     * @param boxes six floats an object: least x y z, greatest x y z; copied
     * @param intersector finds where a ray hits an object; kept as long as the tree
     * @return the objects
     */
    public static UserObjects of(float[] boxes, ObjectIntersector intersector) {
        return new UserObjects(FloatBuffer.wrap(boxes), intersector);
    }

    /**
     * Objects in boxes that contain them.
     *
     * @param boxes six floats an object: least x y z, greatest x y z; borrowed until a tree is
     *     built if direct and in native order, else copied
     * @param intersector finds where a ray hits an object; kept as long as the tree
     * @return the objects
     */
    public static UserObjects of(FloatBuffer boxes, ObjectIntersector intersector) {
        return new UserObjects(boxes, intersector);
    }

    /**
     * How many there are.
     *
     * @return objects
     */
    public int count() {
        return boxes.capacity() / FLOATS;
    }

    ObjectIntersector intersector() {
        return intersector;
    }

    Structs.Objects.ByReference toStruct(ObjectCallback callback) {
        Structs.Objects.ByReference struct = new Structs.Objects.ByReference();
        struct.boxes = Direct.address(boxes);
        struct.count = count();
        struct.intersect = callback;
        return struct;
    }
}
