// SPDX-License-Identifier: MIT
import org.htree.HTree;
import org.htree.Hit;
import org.htree.Mesh;
import org.htree.Ray;

class Minimal {
    public static void main(String[] arguments) {
        float[] positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
        int[] indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
        try (HTree tree = HTree.build(Mesh.of(positions, indices))) {
            Hit hit = tree.intersect(new Ray(2, 2, 2, -1, -1, -1));
            System.out.println(
                    hit.isHit() ? "triangle " + hit.prim() + " at t = " + hit.t() : "miss");
        }
    }
}
