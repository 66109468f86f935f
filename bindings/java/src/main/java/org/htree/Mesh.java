// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.FloatBuffer;
import java.nio.IntBuffer;
import org.htree.raw.Structs;

/**
 * Triangles, and objects if any. Direct buffers in native order are borrowed, and must not change
 * until {@link HTree#build} or {@link HTree#update} returns, and with {@link Options#lazy} until
 * the tree is complete or closed; arrays and other buffers are copied.
 */
public final class Mesh {
    private static final int VERTEX_BYTES = 12;

    private final FloatBuffer positions;
    private final int positionStride;
    private final IntBuffer indices;
    private final long triangleCount;
    private final UserObjects objects;

    private Mesh(Builder builder) {
        positions = builder.positions;
        positionStride = builder.positionStride;
        indices = builder.indices;
        objects = builder.objects;
        triangleCount = builder.triangleCount >= 0 ? builder.triangleCount
                : indices != null ? indices.capacity() / 3 : vertexCount() / 3;
    }

    /**
     * Triangles that share vertices; the arrays are copied.
     *
     * @param positions x y z of every vertex
     * @param indices three a triangle
     * @return the mesh
     */
    public static Mesh of(float[] positions, int[] indices) {
        return of(FloatBuffer.wrap(positions), IntBuffer.wrap(indices));
    }

    /**
     * Triangles that share vertices.
     *
     * @param positions x y z of every vertex
     * @param indices three a triangle
     * @return the mesh
     */
    public static Mesh of(FloatBuffer positions, IntBuffer indices) {
        return builder().positions(positions).indices(indices).build();
    }

    /**
     * A mesh piece by piece.
     *
     * @return a builder of the empty mesh
     */
    public static Builder builder() {
        return new Builder();
    }

    /**
     * How many vertices there are.
     *
     * @return vertices
     */
    public long vertexCount() {
        long bytes = 4L * positions.capacity();
        int stride = positionStride == 0 ? VERTEX_BYTES : positionStride;
        return bytes < VERTEX_BYTES ? 0 : (bytes - VERTEX_BYTES) / stride + 1;
    }

    /**
     * How many triangles there are.
     *
     * @return triangles
     */
    public long triangleCount() {
        return triangleCount;
    }

    /**
     * How many objects there are.
     *
     * @return objects
     */
    public int objectCount() {
        return objects == null ? 0 : objects.count();
    }

    ObjectCallback newCallback() {
        return objectCount() == 0 ? null : new ObjectCallback(objects.intersector());
    }

    /** The struct holds addresses: this mesh must stay reachable while it is used. */
    Structs.Mesh toStruct(ObjectCallback callback) {
        Structs.Mesh struct = new Structs.Mesh();
        struct.positions = Direct.address(positions);
        struct.positionStride = positionStride;
        struct.vertexCount = vertexCount();
        struct.indices = Direct.address(indices);
        struct.triangleCount = triangleCount;
        struct.objects = callback == null ? null : objects.toStruct(callback);
        struct.setAutoRead(false);
        return struct;
    }

    /** Builds a {@link Mesh}. */
    public static final class Builder {
        private FloatBuffer positions = Direct.of(FloatBuffer.allocate(0));
        private int positionStride;
        private IntBuffer indices;
        private long triangleCount = -1;
        private UserObjects objects;

        private Builder() {}

        /**
         * Vertices, tightly packed.
         *
         * @param xyz three floats a vertex, from the buffer's position to its limit
         * @return this
         */
        public Builder positions(FloatBuffer xyz) {
            if (xyz.remaining() % 3 != 0) {
                throw new IllegalArgumentException(xyz.remaining() + " floats: a vertex has 3");
            }
            return positions(xyz, 0);
        }

        /**
         * Vertices among other data.
         *
         * @param xyz x of the first vertex is at the buffer's position
         * @param strideBytes from a vertex to the next, a multiple of 4, at least 12; 0 means 12
         * @return this
         */
        public Builder positions(FloatBuffer xyz, int strideBytes) {
            if (strideBytes < 0) {
                throw new IllegalArgumentException("the stride is " + strideBytes);
            }
            positions = Direct.of(xyz);
            positionStride = strideBytes;
            return this;
        }

        /**
         * Vertices of each triangle. Without this, triangle i has vertices 3i, 3i + 1 and 3i + 2.
         *
         * @param abc three a triangle, unsigned
         * @return this
         */
        public Builder indices(IntBuffer abc) {
            if (abc.remaining() % 3 != 0) {
                throw new IllegalArgumentException(abc.remaining() + " indices: a triangle has 3");
            }
            indices = Direct.of(abc);
            return this;
        }

        /**
         * Uses no more than the first triangles. Without this, all there are.
         *
         * @param count of triangles
         * @return this
         */
        public Builder triangleCount(long count) {
            if (count < 0 || indices != null && count > indices.capacity() / 3) {
                throw new IllegalArgumentException(count + " triangles: not in the indices");
            }
            triangleCount = count;
            return this;
        }

        /**
         * Objects beside the triangles.
         *
         * @param userObjects the objects
         * @return this
         */
        public Builder objects(UserObjects userObjects) {
            objects = userObjects;
            return this;
        }

        /**
         * Ends the builder's work.
         *
         * @return the mesh
         */
        public Mesh build() {
            if (indices != null && triangleCount > indices.capacity() / 3) {
                throw new IllegalArgumentException(
                        triangleCount + " triangles: not in the indices");
            }
            return new Mesh(this);
        }
    }
}
