// SPDX-License-Identifier: MIT
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Random;
import org.htree.HTree;
import org.htree.Hits;
import org.htree.Mesh;
import org.htree.Rays;

/**
 * Renders a wavy floor with a bowl on it, lit from everywhere, to a PGM: one batch of rays finds
 * what each pixel sees, one more finds which of SAMPLES directions of the sky each point sees.
 */
class AmbientOcclusion {
    static final int SIDE = 256;
    static final int SAMPLES = 32;
    static final int CELLS = 96;

    public static void main(String[] arguments) throws IOException {
        Path out = Path.of(arguments.length > 0 ? arguments[0] : "occlusion.pgm");
        try (HTree tree = HTree.build(scene())) {
            Rays eye = eyeRays();
            Hits hits = tree.intersect(eye);
            ByteBuffer occluded = tree.occluded(skyRays(eye, hits));
            Files.write(out, picture(hits, occluded));
            System.out.printf("%s: %d triangles, %d rays%n", out, tree.stats().triangles(),
                    eye.count() * (1 + SAMPLES));
        }
    }

    /** A grid of cells over [-2, 2] x [-2, 2]: waves, and in the middle half a sphere. */
    static Mesh scene() {
        float[] positions = new float[3 * (CELLS + 1) * (CELLS + 1)];
        int[] indices = new int[6 * CELLS * CELLS];
        for (int v = 0; v < positions.length / 3; ++v) {
            double x = 4.0 * (v % (CELLS + 1)) / CELLS - 2;
            double y = 4.0 * (v / (CELLS + 1)) / CELLS - 2;
            double waves = 0.12 * Math.sin(5 * x) * Math.cos(4 * y);
            positions[3 * v] = (float) x;
            positions[3 * v + 1] = (float) y;
            double bowl = Math.sqrt(Math.max(0, 1 - x * x - y * y));
            positions[3 * v + 2] = (float) Math.max(waves, bowl);
        }
        for (int c = 0; c < CELLS * CELLS; ++c) {
            int a = c / CELLS * (CELLS + 1) + c % CELLS;
            int b = a + CELLS + 1;
            int[] pair = {a, a + 1, b, a + 1, b + 1, b};
            System.arraycopy(pair, 0, indices, 6 * c, 6);
        }
        return Mesh.of(positions, indices);
    }

    /** Parallel rays from above, slanted. */
    static Rays eyeRays() {
        Rays rays = Rays.allocate(SIDE * SIDE);
        for (int i = 0; i < rays.count(); ++i) {
            float x = 3.6f * (i % SIDE) / SIDE - 1.8f;
            float y = 1.8f - 3.6f * (i / SIDE) / SIDE;
            rays.set(i, x, y - 3, 4, 0, 0, 0.6f, -0.8f, 100);
        }
        return rays;
    }

    /** SAMPLES rays up from every point that was hit; those of misses point nowhere. */
    static Rays skyRays(Rays eye, Hits hits) {
        Rays rays = Rays.allocate(eye.count() * SAMPLES);
        Random random = new Random(1);
        for (int i = 0; i < rays.count(); ++i) {
            int pixel = i / SAMPLES;
            float t = hits.isHit(pixel) ? hits.t(pixel) : Float.NaN;
            var ray = eye.get(pixel);
            double z = random.nextDouble();
            double angle = 2 * Math.PI * random.nextDouble();
            double radius = Math.sqrt(1 - z * z);
            rays.set(i, ray.orgX(), ray.orgY() + t * ray.dirY(), ray.orgZ() + t * ray.dirZ(), 1e-3f,
                    (float) (radius * Math.cos(angle)), (float) (radius * Math.sin(angle)),
                    (float) z, 100);
        }
        return rays;
    }

    static byte[] picture(Hits hits, ByteBuffer occluded) {
        byte[] header = ("P5\n" + SIDE + " " + SIDE + "\n255\n").getBytes();
        ByteBuffer file = ByteBuffer.allocate(header.length + hits.count()).put(header);
        for (int i = 0; i < hits.count(); ++i) {
            int open = 0;
            for (int j = 0; j < SAMPLES; ++j) {
                open += 1 - occluded.get(i * SAMPLES + j);
            }
            file.put((byte) (hits.isHit(i) ? 255 * open / SAMPLES : 24));
        }
        return file.array();
    }
}
