// SPDX-License-Identifier: MIT
package org.htree;

import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertFalse;
import static org.junit.jupiter.api.Assertions.assertNotNull;
import static org.junit.jupiter.api.Assertions.assertThrows;

import com.sun.jna.Memory;
import com.sun.jna.Pointer;
import com.sun.jna.ptr.PointerByReference;
import java.nio.FloatBuffer;
import java.util.HashMap;
import java.util.Map;
import java.util.function.Consumer;
import java.util.stream.Stream;
import org.htree.raw.LibHTree;
import org.htree.raw.Structs;
import org.junit.jupiter.api.DynamicTest;
import org.junit.jupiter.api.TestFactory;

/** Every mistake of the conformance file gives its status and a sentence. */
class MisuseTest {
    private static final int MANY_RAYS = 100_000;

    private static final Map<String, Runnable> CASES = new HashMap<>();

    static {
        CASES.put("build-index-out-of-range",
                () -> HTree.build(Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4})));
        CASES.put("build-strict-nan", () -> HTree.build(
                Mesh.of(new float[] {Float.NaN, 0, 0, 1, 0, 0, 0, 1, 0}, new int[] {0, 1, 2}),
                Options.builder(Kind.H).strict(true).build()));
        CASES.put("build-buckets-1", () -> build(options -> options.buckets(1)));
        CASES.put("build-axes-2", () -> build(options -> options.axes(2)));
        CASES.put("build-cost-nan", () -> build(options -> options.costs(Float.NaN, 1, 1, 1)));
        CASES.put("build-cost-zero", () -> build(options -> options.costs(1, 1, 1, 0)));
        CASES.put("build-cells-huge", () -> build(options -> options.cellsPerPrim(1e9f)));
        CASES.put("build-few-prims-0", () -> build(options -> options.fewPrims(0)));
        CASES.put("build-stride-8", () -> HTree.build(Mesh.builder()
                .positions(FloatBuffer.wrap(Fixtures.TETRAHEDRON), 8).triangleCount(1).build()));
        CASES.put("build-too-few-vertices", () -> HTree.build(Mesh.builder()
                .positions(FloatBuffer.wrap(new float[9])).triangleCount(2).build()));
        CASES.put("build-cancelled", () -> HTree.build(Fixtures.terrain(50),
                Options.builder(Kind.H).progress(fraction -> true).build()));
        CASES.put("query-cancelled", () -> query(tree -> tree.intersect(
                Rays.allocate(MANY_RAYS), Hits.allocate(MANY_RAYS),
                Query.DEFAULT.withThreads(1).withProgress(fraction -> true))));
        CASES.put("view-lazy", () -> HTree.build(Fixtures.terrain(60),
                Options.builder(Kind.WIDE).lazy(true).build()).view());
        CASES.put("update-index-out-of-range", () -> query(tree -> tree.update(
                Mesh.of(Fixtures.TETRAHEDRON, new int[] {0, 1, 4}), How.REBUILD)));

        // What the types above make impossible, by the layer below.
        CASES.put("build-kind-unknown", () -> rawBuild(options -> options.kind = 99));
        CASES.put("build-flags-unknown", () -> rawBuild(options -> options.flags = 0x80000000));
        CASES.put("build-positions-null", () -> {
            Structs.Mesh mesh = new Structs.Mesh();
            mesh.triangleCount = 1;
            check(LibHTree.htree_build(new PointerByReference(), mesh, null));
        });
        CASES.put("options-size-0",
                () -> check(LibHTree.htree_options_init(new Structs.Options(), 0, Kind.H.code())));
        CASES.put("query-size-0", () -> check(LibHTree.htree_query_init(new Structs.Query(), 0)));
        CASES.put("query-flags-unknown", () -> rawQuery(tree -> {
            Structs.Query query = new Structs.Query();
            check(LibHTree.htree_query_init(query, query.size()));
            query.flags = 1;
            check(LibHTree.htree_intersect(tree, new Memory(32), 1, new Memory(16), query));
        }));
        CASES.put("stats-size-0",
                () -> rawQuery(tree -> check(LibHTree.htree_get_stats(tree, new Structs.Stats()))));
        CASES.put("view-size-0",
                () -> rawQuery(tree -> check(LibHTree.htree_get_view(tree, new Structs.View()))));
        CASES.put("update-how-3", () -> rawQuery(
                tree -> check(LibHTree.htree_update(tree, new Structs.Mesh(), 3, null))));
        CASES.put("update-mesh-null", () -> rawQuery(
                tree -> check(LibHTree.htree_update(tree, null, How.REFIT.code(), null))));
        CASES.put("complete-null", () -> check(LibHTree.htree_complete(null)));
        CASES.put("rays-null", () -> rawQuery(
                tree -> check(LibHTree.htree_intersect(tree, null, 1, new Memory(16), null))));
        CASES.put("hits-null", () -> rawQuery(
                tree -> check(LibHTree.htree_intersect(tree, new Memory(32), 1, null, null))));
        CASES.put("tree-null", () -> check(
                LibHTree.htree_intersect(null, new Memory(32), 1, new Memory(16), null)));
        CASES.put("out-null", () -> check(LibHTree.htree_build(null, new Structs.Mesh(), null)));
        CASES.put("mesh-null",
                () -> check(LibHTree.htree_build(new PointerByReference(), null, null)));
    }

    @TestFactory
    Stream<DynamicTest> mistakeGivesItsStatus() {
        Conformance file = Conformance.read();
        assertFalse(file.misuse.isEmpty());
        return file.misuse.stream().map(misuse -> DynamicTest.dynamicTest(misuse.name, () -> {
            Runnable mistake = CASES.get(misuse.name);
            assertNotNull(mistake, "a case that this test does not know");
            HTreeException thrown = assertThrows(HTreeException.class, mistake::run);
            assertEquals(Status.valueOf(misuse.status), thrown.status());
            assertEquals(file.statuses.get(misuse.status), thrown.code());
            assertEquals(file.statusNames.get(Integer.toString(thrown.code())), thrown.words());
            assertFalse(thrown.getMessage().isEmpty());
        }));
    }

    private static void check(int status) {
        HTreeException.check(status);
    }

    private static void build(Consumer<Options.Builder> mistake) {
        Options.Builder options = Options.builder(Kind.AH);
        mistake.accept(options);
        HTree.build(Fixtures.tetrahedron(), options.build());
    }

    private static void query(Consumer<HTree> mistake) {
        try (HTree tree = HTree.build(Fixtures.tetrahedron())) {
            mistake.accept(tree);
        }
    }

    private static void rawBuild(Consumer<Structs.Options> mistake) {
        Structs.Options options = new Structs.Options();
        check(LibHTree.htree_options_init(options, options.size(), Kind.H.code()));
        mistake.accept(options);
        check(LibHTree.htree_build(new PointerByReference(), new Structs.Mesh(), options));
    }

    private static void rawQuery(Consumer<Pointer> mistake) {
        PointerByReference out = new PointerByReference();
        check(LibHTree.htree_build(out, new Structs.Mesh(), null));
        try {
            mistake.accept(out.getValue());
        } finally {
            LibHTree.htree_free(out.getValue());
        }
    }
}
