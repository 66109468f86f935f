// SPDX-License-Identifier: MIT
package org.htree.raw;

import com.sun.jna.Pointer;
import com.sun.jna.Structure;
import com.sun.jna.Structure.FieldOrder;

/** The structs of {@code htree.h}, with the fields in their order. */
public final class Structs {
    private Structs() {}

    /** {@code htree_box}. */
    @FieldOrder({"lo", "hi"})
    public static class Box extends Structure {
        /** Least x, y, z. */
        public float[] lo = new float[3];

        /** Greatest x, y, z. */
        public float[] hi = new float[3];

        /** A zeroed struct. */
        public Box() {}
    }

    /** {@code htree_objects}. */
    @FieldOrder({"boxes", "count", "intersect", "user"})
    public static class Objects extends Structure {
        /** {@code count} boxes. */
        public Pointer boxes;

        /** Objects. */
        public long count;

        /** The test, which must stay reachable as long as the tree. */
        public Callbacks.ObjectIntersect intersect;

        /** Handed to {@code intersect}. */
        public Pointer user;

        /** A zeroed struct. */
        public Objects() {}

        /** By address. */
        public static class ByReference extends Objects implements Structure.ByReference {
            /** A zeroed struct. */
            public ByReference() {}
        }
    }

    /** {@code htree_mesh}. */
    @FieldOrder({
        "positions", "positionStride", "vertexCount", "indices", "triangleCount", "objects",
        "reserved"
    })
    public static class Mesh extends Structure {
        /** x y z of every vertex. */
        public Pointer positions;

        /** Bytes from vertex to vertex; 0 means 12. */
        public long positionStride;

        /** Vertices. */
        public long vertexCount;

        /** Three a triangle, or null. */
        public Pointer indices;

        /** Triangles. */
        public long triangleCount;

        /** Objects, or null. */
        public Objects.ByReference objects;

        /** Zero. */
        public long[] reserved = new long[2];

        /** A zeroed struct. */
        public Mesh() {}
    }

    /** {@code htree_allocator}. */
    @FieldOrder({"allocate", "release", "user"})
    public static class Allocator extends Structure {
        /** Gets memory. */
        public Callbacks.Allocate allocate;

        /** Gives it back. */
        public Callbacks.Release release;

        /** Handed to both. */
        public Pointer user;

        /** A zeroed struct. */
        public Allocator() {}
    }

    /** {@code htree_tasks}. */
    @FieldOrder({"run", "user"})
    public static class Tasks extends Structure {
        /** Parallel for. */
        public Callbacks.Run run;

        /** Handed to {@code run}. */
        public Pointer user;

        /** A zeroed struct. */
        public Tasks() {}
    }

    /** {@code htree_progress}. */
    @FieldOrder({"report", "user"})
    public static class Progress extends Structure {
        /** Gets the fraction. */
        public Callbacks.Report report;

        /** Handed to {@code report}. */
        public Pointer user;

        /** A zeroed struct. */
        public Progress() {}
    }

    /** {@code htree_options}. */
    @FieldOrder({
        "size", "kind", "flags", "threads", "buckets", "axes", "costSkd", "costBv2", "costBv6",
        "costIntersect", "cellsPerPrim", "fewPrims", "allocator", "tasks", "progress"
    })
    public static class Options extends Structure {
        /** Bytes of the struct. */
        public int size;

        /** Kind of tree. */
        public int kind;

        /** {@code HTREE_STRICT}, ... */
        public int flags;

        /** Threads of queries. */
        public int threads;

        /** Buckets of the surface area heuristic. */
        public int buckets;

        /** Axes to try. */
        public int axes;

        /** Cost of two separating planes. */
        public float costSkd;

        /** Cost of two bounding planes. */
        public float costBv2;

        /** Cost of six bounding planes. */
        public float costBv6;

        /** Cost of an object test. */
        public float costIntersect;

        /** Cells of the grid for each object. */
        public float cellsPerPrim;

        /** Objects that the AH-tree hands to the H-tree. */
        public int fewPrims;

        /** Memory. */
        public Allocator allocator;

        /** Threads. */
        public Tasks tasks;

        /** Progress of the build. */
        public Progress progress;

        /** A zeroed struct. */
        public Options() {}
    }

    /** {@code htree_load_options}. */
    @FieldOrder({
        "size", "flags", "threads", "reserved", "intersect", "user", "allocator", "tasks"
    })
    public static class LoadOptions extends Structure {
        /** Bytes of the struct. */
        public int size;

        /** {@code HTREE_BORROW}. */
        public int flags;

        /** Threads of queries. */
        public int threads;

        /** Zero. */
        public int reserved;

        /** The test of objects, which must stay reachable as long as the tree. */
        public Callbacks.ObjectIntersect intersect;

        /** Handed to {@code intersect}. */
        public Pointer user;

        /** Memory. */
        public Allocator allocator;

        /** Threads. */
        public Tasks tasks;

        /** A zeroed struct. */
        public LoadOptions() {}
    }

    /** {@code htree_query}. */
    @FieldOrder({"size", "flags", "threads", "reserved", "counters", "progress"})
    public static class Query extends Structure {
        /** Bytes of the struct. */
        public int size;

        /** Zero. */
        public int flags;

        /** Threads of the query. */
        public int threads;

        /** Zero. */
        public int reserved;

        /** Sixteen bytes a ray, or null. */
        public Pointer counters;

        /** Progress of the query. */
        public Progress progress;

        /** A zeroed struct. */
        public Query() {}
    }

    /** {@code htree_stats}. */
    @FieldOrder({
        "size", "kind", "triangles", "objects", "invalid", "degenerate", "nodes", "leaves",
        "references", "skdNodes", "bv2Nodes", "bv6Nodes", "linkNodes", "bvoNodes", "ternaryNodes",
        "depth", "stack", "bytes", "peakBytes", "buildSeconds", "sahCost", "subtrees",
        "subtreesBuilt"
    })
    public static class Stats extends Structure {
        /** Bytes of the struct. */
        public int size;

        /** Kind of tree. */
        public int kind;

        /** Triangles as given. */
        public long triangles;

        /** Objects as given. */
        public long objects;

        /** Skipped for bad coordinates. */
        public long invalid;

        /** Skipped for lack of area. */
        public long degenerate;

        /** All nodes. */
        public long nodes;

        /** Leaves. */
        public long leaves;

        /** References from leaves to triangles and objects. */
        public long references;

        /** Nodes with two separating planes. */
        public long skdNodes;

        /** Nodes with two bounding planes. */
        public long bv2Nodes;

        /** Nodes with six bounding planes. */
        public long bv6Nodes;

        /** Links. */
        public long linkNodes;

        /** Nodes with another set of bounding planes. */
        public long bvoNodes;

        /** Nodes with a shelf of oversize objects. */
        public long ternaryNodes;

        /** Nodes from the root to the deepest leaf. */
        public int depth;

        /** Entries of the traversal stack. */
        public int stack;

        /** Memory of the tree. */
        public long bytes;

        /** Most memory held while building. */
        public long peakBytes;

        /** Wall-clock time of the build. */
        public double buildSeconds;

        /** Expected cost of a random ray. */
        public double sahCost;

        /** Left to rays. */
        public long subtrees;

        /** Of these, built by now. */
        public long subtreesBuilt;

        /** A zeroed struct. */
        public Stats() {}
    }

    /** {@code htree_view}. */
    @FieldOrder({
        "size", "kind", "bounds", "prims", "triangleCount", "objectCount", "stack", "triangles",
        "nodes", "nodeBytes", "leaves", "leafBytes", "grid", "gridBytes"
    })
    public static class View extends Structure {
        /** Bytes of the struct. */
        public int size;

        /** Kind of tree. */
        public int kind;

        /** Bounds of what can be hit. */
        public Box bounds;

        /** What can be hit. */
        public int prims;

        /** Triangles of the mesh. */
        public int triangleCount;

        /** Objects of the mesh. */
        public int objectCount;

        /** Entries of the traversal stack. */
        public int stack;

        /** Nine floats a triangle, or null. */
        public Pointer triangles;

        /** Nodes, root first. */
        public Pointer nodes;

        /** Their size. */
        public long nodeBytes;

        /** Leaves, or null. */
        public Pointer leaves;

        /** Their size. */
        public long leafBytes;

        /** Grid, or null. */
        public Pointer grid;

        /** Its size. */
        public long gridBytes;

        /** A zeroed struct. */
        public View() {}
    }
}
