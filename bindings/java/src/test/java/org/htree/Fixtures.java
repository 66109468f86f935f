// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;

/** Meshes and rays that the tests share. */
final class Fixtures {
    private Fixtures() {}

    static final float[] TETRAHEDRON = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static final int[] TETRAHEDRON_FACES = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

    static Mesh tetrahedron() {
        return Mesh.of(TETRAHEDRON, TETRAHEDRON_FACES);
    }

    /** Heights over n x n cells of the unit square. */
    static Mesh terrain(int n) {
        float[] positions = new float[3 * (n + 1) * (n + 1)];
        int[] indices = new int[6 * n * n];
        int at = 0;
        for (int j = 0; j <= n; ++j) {
            for (int i = 0; i <= n; ++i) {
                positions[at++] = (float) i / n;
                positions[at++] = (float) j / n;
                positions[at++] = 0.1f * (float) (Math.sin(9.0 * i / n) * Math.cos(7.0 * j / n));
            }
        }
        at = 0;
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                int a = j * (n + 1) + i;
                int b = a + n + 1;
                for (int vertex : new int[] {a, a + 1, b, a + 1, b + 1, b}) {
                    indices[at++] = vertex;
                }
            }
        }
        return Mesh.of(positions, indices);
    }

    /** Rays from above that hit a terrain in side x side places, some of them past its border. */
    static Rays above(int side) {
        Rays rays = Rays.allocate(side * side);
        for (int i = 0; i < rays.count(); ++i) {
            float x = 1.2f * (i % side) / side - 0.1f;
            float y = 1.2f * (i / side) / side - 0.1f;
            rays.set(i, new Ray(x, y, 2, 0.01f, 0.02f, -1));
        }
        return rays;
    }

    static ByteBuffer bits(int... words) {
        ByteBuffer bytes =
                ByteBuffer.allocateDirect(4 * words.length).order(ByteOrder.nativeOrder());
        bytes.asIntBuffer().put(words);
        return bytes;
    }

    static FloatBuffer floats(int... words) {
        return bits(words).asFloatBuffer();
    }

    static IntBuffer ints(int... words) {
        return bits(words).asIntBuffer();
    }

    static int[] words(Hits hits) {
        int[] words = new int[4 * hits.count()];
        hits.buffer().asIntBuffer().get(words);
        return words;
    }
}
