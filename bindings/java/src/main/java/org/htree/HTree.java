// SPDX-License-Identifier: MIT
package org.htree;

import com.sun.jna.Pointer;
import com.sun.jna.ptr.DoubleByReference;
import com.sun.jna.ptr.LongByReference;
import com.sun.jna.ptr.PointerByReference;
import java.lang.ref.Cleaner;
import java.lang.ref.Reference;
import java.nio.ByteBuffer;
import java.util.Objects;
import org.htree.raw.LibHTree;
import org.htree.raw.Structs;

/**
 * A hierarchy over a mesh. Any number of threads may query it; only {@link #update} and {@link
 * #complete} change it: they wait for the queries that run, and queries for them.
 *
 * <pre>{@code
 * try (HTree tree = HTree.build(mesh)) {
 *     Hits hits = tree.intersect(rays);
 * }
 * }</pre>
 *
 * <p>Its memory is the library's, not the heap's: close it, or it waits for the garbage collector.
 * Closing while queries run on other threads is safe: they end, and the last of them frees the
 * tree.
 */
public final class HTree implements AutoCloseable {
    private static final Cleaner CLEANER = Cleaner.create();

    private final Handle handle;
    private final Cleaner.Cleanable cleanable;

    private HTree(Handle handle) {
        this.handle = handle;
        cleanable = CLEANER.register(this, handle);
    }

    /**
     * Builds a tree of {@link Kind#BALANCED}.
     *
     * @param mesh to build over
     * @return the tree, to be closed
     * @throws HTreeException MEMORY, LIMIT, GEOMETRY
     */
    public static HTree build(Mesh mesh) {
        return build(mesh, Options.of(Kind.BALANCED));
    }

    /**
     * Builds a tree.
     *
     * @param mesh to build over
     * @param options how
     * @return the tree, to be closed
     * @throws HTreeException ARGUMENT, MEMORY, LIMIT, GEOMETRY, CANCELLED, UNSUPPORTED
     */
    public static HTree build(Mesh mesh, Options options) {
        ProgressCallback progress = ProgressCallback.of(options.progress());
        ObjectCallback objects = mesh.newCallback();
        PointerByReference out = new PointerByReference();
        int status;
        try {
            status = LibHTree.htree_build(out, mesh.toStruct(objects), options.toStruct(progress));
        } finally {
            Reference.reachabilityFence(mesh);
            Reference.reachabilityFence(progress);
        }
        if (progress != null && progress.hasThrown()) {
            LibHTree.htree_free(out.getValue());
            throw progress.thrown();
        }
        HTreeException.check(status);
        return new HTree(new Handle(out.getValue(), options.lazy(), mesh, objects));
    }

    /**
     * Builds what rays have not reached yet of a tree with {@link Options#lazy}, on all cores, and
     * lets its mesh go. Does nothing to any other tree. Hits are the same before and after.
     *
     * @throws IllegalStateException if the tree is closed, or if a callback of a query on it calls
     *     this on the query's thread; on another thread it would wait for itself
     */
    public void complete() {
        Pointer tree = handle.acquireAlone();
        try {
            HTreeException.check(LibHTree.htree_complete(tree));
            handle.dropMesh();
        } finally {
            handle.release();
        }
    }

    /**
     * Brings the tree to new positions, or with {@link How#REBUILD} to any mesh at all, with the
     * options that it was built with. What throws leaves the tree as it was.
     *
     * <p>Refitting is for a mesh of as many triangles and objects. The tree is rebuilt where it
     * cannot do: other kinds, a lazy or a compact tree, or other triangles than before that can be
     * hit.
     *
     * @param mesh as it is now
     * @param how to bring the tree there
     * @return the expected cost of a ray over that when the tree was built: 1 after a rebuild; from
     *     about 1.5 on rebuilding pays
     * @throws HTreeException ARGUMENT, MEMORY, LIMIT, GEOMETRY
     * @throws IllegalStateException as {@link #complete}
     */
    public double update(Mesh mesh, How how) {
        ObjectCallback objects = mesh.newCallback();
        DoubleByReference quality = new DoubleByReference();
        Structs.Mesh struct = mesh.toStruct(objects);
        int code = how.code();
        Pointer tree = handle.acquireAlone();
        try {
            HTreeException.check(LibHTree.htree_update(tree, struct, code, quality));
            handle.keep(mesh, objects);
        } finally {
            handle.release();
            Reference.reachabilityFence(mesh);
        }
        return quality.getValue();
    }

    /**
     * Loads what {@link #save} wrote, a tree without objects.
     *
     * @param file its bytes, from position to limit
     * @return the tree, to be closed
     * @throws HTreeException CORRUPT, MEMORY, UNSUPPORTED
     */
    public static HTree load(ByteBuffer file) {
        return load(file, 0, null);
    }

    /**
     * Loads what {@link #save} wrote: the same hits. Whatever the bytes are, what is returned has
     * been proved.
     *
     * @param file its bytes, from position to limit; copied
     * @param threads of queries: 0 all cores, 1 the caller's, n at most n
     * @param intersector of the tree's objects, or null if it has none; kept as long as the tree
     * @return the tree, to be closed
     * @throws HTreeException ARGUMENT, CORRUPT, MEMORY, UNSUPPORTED
     */
    public static HTree load(ByteBuffer file, int threads, ObjectIntersector intersector) {
        ByteBuffer bytes = Direct.of(file);
        ObjectCallback objects = intersector == null ? null : new ObjectCallback(intersector);
        Structs.LoadOptions options = new Structs.LoadOptions();
        HTreeException.check(LibHTree.htree_load_options_init(options, options.size()));
        options.threads = Query.requireThreads(threads);
        options.intersect = objects;
        PointerByReference out = new PointerByReference();
        int status;
        try {
            status = LibHTree.htree_load(
                    out, Direct.address(bytes), bytes.remaining(), options);
        } finally {
            Reference.reachabilityFence(bytes);
        }
        HTreeException.check(status);
        return new HTree(new Handle(out.getValue(), false, null, objects));
    }

    /**
     * The tree as bytes, for {@link #load}; objects are saved as their boxes.
     *
     * @return a direct buffer
     * @throws IllegalArgumentException if they exceed the 2 GiB of a Java buffer
     * @throws IllegalStateException if the tree is closed
     */
    public ByteBuffer save() {
        LongByReference size = new LongByReference();
        inspect(tree -> LibHTree.htree_save(tree, null, 0, size));
        ByteBuffer file = Direct.bytes(size.getValue());
        inspect(tree -> LibHTree.htree_save(tree, Direct.address(file), file.capacity(), size));
        return file;
    }

    /**
     * Finds the closest hit of every ray.
     *
     * @param rays to trace
     * @return a hit for each
     */
    public Hits intersect(Rays rays) {
        Hits hits = Hits.allocate(rays.count());
        intersect(rays, hits, null);
        return hits;
    }

    /**
     * Finds the closest hit of every ray.
     *
     * @param rays to trace
     * @param hits room for at least as many
     * @param query how, or null: on the threads of the tree's options
     * @throws HTreeException CANCELLED, and then the hits are unspecified
     * @throws IllegalArgumentException if there are more rays than room for their hits
     * @throws IllegalStateException if the tree is closed
     */
    public void intersect(Rays rays, Hits hits, Query query) {
        requireRoom("hits", hits.count(), rays);
        trace(LibHTree::htree_intersect, rays, hits.buffer(), query);
    }

    /**
     * Finds the closest hit of one ray, on this thread.
     *
     * @param ray to trace
     * @return its hit
     */
    public Hit intersect(Ray ray) {
        return intersect(Rays.of(ray)).get(0);
    }

    /**
     * Finds which rays hit anything.
     *
     * @param rays to trace
     * @return a byte for each: 1 if it hits anything, else 0
     */
    public ByteBuffer occluded(Rays rays) {
        ByteBuffer occluded = Direct.bytes(rays.count());
        occluded(rays, occluded, null);
        return occluded;
    }

    /**
     * Finds which rays hit anything: faster than the closest hits.
     *
     * @param rays to trace
     * @param occluded a direct buffer with room from its position to its limit; gets 1 for every
     *     ray that hits anything, else 0
     * @param query how, or null: on the threads of the tree's options
     * @throws HTreeException CANCELLED, and then the answers are unspecified
     * @throws IllegalArgumentException if there are more rays than room for their answers
     * @throws IllegalStateException if the tree is closed
     */
    public void occluded(Rays rays, ByteBuffer occluded, Query query) {
        ByteBuffer answers = Direct.writable(occluded);
        requireRoom("occluded", answers.capacity(), rays);
        trace(LibHTree::htree_occluded, rays, answers, query);
    }

    /**
     * Tells whether one ray hits anything, on this thread.
     *
     * @param ray to trace
     * @return true if it does
     */
    public boolean occluded(Ray ray) {
        return occluded(Rays.of(ray)).get(0) != 0;
    }

    /**
     * Bounds of everything that can be hit.
     *
     * @return the box; lo = +inf, hi = -inf if there is nothing
     */
    public Box bounds() {
        Structs.Box struct = new Structs.Box();
        inspect(tree -> LibHTree.htree_get_bounds(tree, struct));
        return Box.of(struct);
    }

    /**
     * Walks the tree and counts what it is made of.
     *
     * @return the statistics
     */
    public Stats stats() {
        Structs.Stats struct = new Structs.Stats();
        struct.size = struct.size();
        inspect(tree -> LibHTree.htree_get_stats(tree, struct));
        return Stats.of(struct);
    }

    /**
     * Copies the arrays of the tree.
     *
     * @return the copies
     * @throws HTreeException UNSUPPORTED for a lazy tree that is not complete, and for a compact one
     * @throws IllegalArgumentException if an array exceeds the 2 GiB of a Java buffer
     */
    public View view() {
        Structs.View struct = new Structs.View();
        struct.size = struct.size();
        Pointer tree = handle.acquire();
        try {
            HTreeException.check(LibHTree.htree_get_view(tree, struct));
            return View.copyOf(struct);
        } finally {
            handle.release();
        }
    }

    /**
     * Proves the structure: every node is reached once, and every box contains what lies below it.
     *
     * @throws HTreeException CORRUPT, MEMORY
     */
    public void check() {
        inspect(LibHTree::htree_check);
    }

    /**
     * Tells whether the tree was closed.
     *
     * @return true after {@link #close}
     */
    public boolean isClosed() {
        return handle.isClosed();
    }

    /** Frees the tree, after the last query that runs on it. Closing twice does nothing. */
    @Override
    public void close() {
        cleanable.clean();
    }

    /**
     * Version of the library that was loaded.
     *
     * @return for example "0.1.0"
     */
    public static String libraryVersion() {
        int version = LibHTree.htree_version();
        return dotted(version / 10000, version / 100 % 100, version % 100);
    }

    /**
     * Version of the library that this binding was written for.
     *
     * @return for example "0.1.0"
     */
    public static String bindingVersion() {
        return dotted(LibHTree.VERSION_MAJOR, LibHTree.VERSION_MINOR, LibHTree.VERSION_PATCH);
    }

    private static String dotted(int major, int minor, int patch) {
        return major + "." + minor + "." + patch;
    }

    /** {@code htree_intersect} or {@code htree_occluded}. */
    private interface Trace {
        int run(Pointer tree, Pointer rays, long count, Pointer answers, Structs.Query query);
    }

    private void trace(Trace trace, Rays rays, ByteBuffer answers, Query query) {
        if (query != null && query.counters() != null) {
            requireRoom("counters", query.counters().count(), rays);
        }
        ProgressCallback progress = ProgressCallback.of(query == null ? null : query.progress());
        Pointer tree = handle.acquire();
        try {
            ObjectCallback objects = handle.callback();
            long failures = objects == null ? 0 : objects.failures();
            int status = trace.run(tree, Direct.address(rays.buffer()), rays.count(),
                    Direct.address(answers), query == null ? null : query.toStruct(progress));
            if (progress != null && progress.hasThrown()) {
                throw progress.thrown();
            }
            HTreeException.check(status);
            if (objects != null && objects.failures() != failures) {
                throw objects.thrown();
            }
        } finally {
            handle.release();
            Reference.reachabilityFence(rays);
            Reference.reachabilityFence(answers);
            Reference.reachabilityFence(query);
            Reference.reachabilityFence(progress);
        }
    }

    /** A call that asks the tree. */
    private interface Inspection {
        int run(Pointer tree);
    }

    private void inspect(Inspection inspection) {
        Pointer tree = handle.acquire();
        try {
            HTreeException.check(inspection.run(tree));
        } finally {
            handle.release();
        }
    }

    private static void requireRoom(String what, int room, Rays rays) {
        Objects.requireNonNull(rays, "rays");
        if (room < rays.count()) {
            throw new IllegalArgumentException(
                    what + " has room for " + room + " answers to " + rays.count() + " rays");
        }
    }
}
