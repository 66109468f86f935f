// SPDX-License-Identifier: MIT
package org.htree.raw;

import com.sun.jna.Native;
import com.sun.jna.NativeLibrary;
import java.io.File;
import java.io.IOException;

/** Finds the library, and refuses one whose structs may differ from ours. */
final class Loader {
    private static final String NAME = "htree";

    private Loader() {}

    static NativeLibrary load() {
        NativeLibrary library = open();
        requireCompatible(library.getFunction("htree_version").invokeInt(new Object[0]), library);
        return library;
    }

    private static NativeLibrary open() {
        if (isOnLibraryPath()) {
            return NativeLibrary.getInstance(NAME);
        }
        File unpacked;
        try {
            unpacked = Native.extractFromResourcePath(NAME, Loader.class.getClassLoader());
        } catch (IOException notInJar) {
            return NativeLibrary.getInstance(NAME);
        }
        NativeLibrary library = NativeLibrary.getInstance(unpacked.getAbsolutePath());
        deleteIfTemporary(unpacked);
        return library;
    }

    /** JNA would prefer the system's library to the jar's, which the caller did not ask for. */
    private static boolean isOnLibraryPath() {
        for (String folder : System.getProperty("jna.library.path", "").split(File.pathSeparator)) {
            if (!folder.isEmpty() && new File(folder, System.mapLibraryName(NAME)).exists()) {
                return true;
            }
        }
        return false;
    }

    /** A class path of folders holds the library as a file of its own, which must stay. */
    private static void deleteIfTemporary(File library) {
        if (library.getName().startsWith("jna") && !library.delete()) {
            library.deleteOnExit();
        }
    }

    static void requireCompatible(int version, Object library) {
        int major = version / 10000;
        int minor = version / 100 % 100;
        boolean fits = major == LibHTree.VERSION_MAJOR
                && (major != 0 || minor == LibHTree.VERSION_MINOR);
        if (!fits) {
            throw new UnsatisfiedLinkError(String.format(
                    "%s has version %d.%d.%d; this binding needs %d.%d",
                    library, major, minor, version % 100,
                    LibHTree.VERSION_MAJOR, LibHTree.VERSION_MINOR));
        }
    }
}
