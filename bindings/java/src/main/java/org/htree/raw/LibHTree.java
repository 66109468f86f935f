// SPDX-License-Identifier: MIT
package org.htree.raw;

import com.sun.jna.Native;
import com.sun.jna.Pointer;
import com.sun.jna.ptr.DoubleByReference;
import com.sun.jna.ptr.LongByReference;
import com.sun.jna.ptr.PointerByReference;

/**
 * The functions of {@code htree.h}, one to one: what each means and may fail with is written there.
 * Nothing here is checked, and a wrong pointer ends the process; {@link org.htree.HTree} is the
 * safe way in.
 *
 * <p>The library is loaded when this class is first used: from {@code jna.library.path} if it is
 * there, else from the jar, else from where the system keeps its libraries. One of another ABI is
 * refused with an {@link UnsatisfiedLinkError}.
 */
public final class LibHTree {
    /** Major version of the ABI that this class declares. */
    public static final int VERSION_MAJOR = 0;

    /** Minor version of the ABI that this class declares. */
    public static final int VERSION_MINOR = 1;

    /** Patch version that this class was written for; any other will do. */
    public static final int VERSION_PATCH = 0;

    static {
        Native.register(LibHTree.class, Loader.load());
    }

    private LibHTree() {}

    /**
     * Version of the library.
     *
     * @return major * 10000 + minor * 100 + patch
     */
    public static native int htree_version();

    /**
     * Name of a status.
     *
     * @param status a number
     * @return never null
     */
    public static native String htree_status_name(int status);

    /**
     * What was wrong in the last call that failed on this thread.
     *
     * @return a sentence, or the empty string
     */
    public static native String htree_error_text();

    /**
     * Name of a kind.
     *
     * @param kind a number
     * @return the name, or null
     */
    public static native String htree_kind_name(int kind);

    /**
     * Kind of a name.
     *
     * @param name or null
     * @return the kind, or 0
     */
    public static native int htree_kind_from_name(String name);

    /**
     * Writes the defaults of a kind.
     *
     * @param options to write
     * @param size of the struct
     * @param kind of tree
     * @return a status
     */
    public static native int htree_options_init(Structs.Options options, long size, int kind);

    /**
     * Measures the costs on this machine.
     *
     * @param options to write them to
     * @return a status
     */
    public static native int htree_calibrate(Structs.Options options);

    /**
     * Builds a tree.
     *
     * @param out gets the tree
     * @param mesh to build over
     * @param options or null
     * @return a status
     */
    public static native int htree_build(
            PointerByReference out, Structs.Mesh mesh, Structs.Options options);

    /**
     * Builds what rays have not reached yet of a lazy tree.
     *
     * @param tree to complete
     * @return a status
     */
    public static native int htree_complete(Pointer tree);

    /**
     * Brings a tree to a mesh.
     *
     * @param tree to change
     * @param mesh as it is now
     * @param how {@code HTREE_REBUILD}, 1, or {@code HTREE_REFIT}, 2
     * @param quality gets the cost over that when the tree was built, or null
     * @return a status
     */
    public static native int htree_update(
            Pointer tree, Structs.Mesh mesh, int how, DoubleByReference quality);

    /**
     * Frees a tree.
     *
     * @param tree or null
     */
    public static native void htree_free(Pointer tree);

    /**
     * Writes the defaults of a query.
     *
     * @param query to write
     * @param size of the struct
     * @return a status
     */
    public static native int htree_query_init(Structs.Query query, long size);

    /**
     * Finds the closest hits.
     *
     * @param tree to ask
     * @param rays of 32 bytes
     * @param count of rays
     * @param hits of 16 bytes
     * @param query or null
     * @return a status
     */
    public static native int htree_intersect(
            Pointer tree, Pointer rays, long count, Pointer hits, Structs.Query query);

    /**
     * Finds which rays hit anything.
     *
     * @param tree to ask
     * @param rays of 32 bytes
     * @param count of rays
     * @param occluded a byte a ray
     * @param query or null
     * @return a status
     */
    public static native int htree_occluded(
            Pointer tree, Pointer rays, long count, Pointer occluded, Structs.Query query);

    /**
     * Writes a tree as bytes.
     *
     * @param tree to save
     * @param file room for {@code size} bytes, or null
     * @param size of the room
     * @param bytes gets how many they are
     * @return a status
     */
    public static native int htree_save(
            Pointer tree, Pointer file, long size, LongByReference bytes);

    /**
     * Writes the defaults of a load.
     *
     * @param options to write
     * @param size of the struct
     * @return a status
     */
    public static native int htree_load_options_init(Structs.LoadOptions options, long size);

    /**
     * Makes a tree of bytes.
     *
     * @param out gets the tree
     * @param file the bytes
     * @param size how many
     * @param options or null
     * @return a status
     */
    public static native int htree_load(
            PointerByReference out, Pointer file, long size, Structs.LoadOptions options);

    /**
     * Bounds of what can be hit.
     *
     * @param tree to ask
     * @param bounds to fill
     * @return a status
     */
    public static native int htree_get_bounds(Pointer tree, Structs.Box bounds);

    /**
     * Counts nodes and leaves.
     *
     * @param tree to ask
     * @param stats to fill; size is set
     * @return a status
     */
    public static native int htree_get_stats(Pointer tree, Structs.Stats stats);

    /**
     * The arrays of a tree.
     *
     * @param tree to ask
     * @param view to fill; size is set
     * @return a status
     */
    public static native int htree_get_view(Pointer tree, Structs.View view);

    /**
     * Proves the structure.
     *
     * @param tree to prove
     * @return a status
     */
    public static native int htree_check(Pointer tree);
}
