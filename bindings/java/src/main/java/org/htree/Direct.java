// SPDX-License-Identifier: MIT
package org.htree;

import com.sun.jna.Native;
import com.sun.jna.Pointer;
import java.nio.Buffer;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.IntBuffer;

/** Memory that C can read: direct buffers in the order of this machine. */
final class Direct {
    private Direct() {}

    static ByteBuffer bytes(long count) {
        if (count < 0 || count > Integer.MAX_VALUE) {
            throw new IllegalArgumentException(
                    count + " bytes: a Java buffer holds fewer than 2^31");
        }
        return ByteBuffer.allocateDirect((int) count).order(ByteOrder.nativeOrder());
    }

    /** The floats from position to limit: themselves if C can read them, else a copy. */
    static FloatBuffer of(FloatBuffer floats) {
        FloatBuffer slice = floats.slice();
        return isReadable(slice, floats.order()) ? slice : copy(slice);
    }

    /** The ints from position to limit: themselves if C can read them, else a copy. */
    static IntBuffer of(IntBuffer ints) {
        IntBuffer slice = ints.slice();
        return isReadable(slice, ints.order()) ? slice : copy(slice);
    }

    /** The bytes from position to limit: themselves if C can read them, else a copy. */
    static ByteBuffer of(ByteBuffer bytes) {
        ByteBuffer slice = bytes.slice();
        return slice.isDirect() ? slice : bytes(slice.remaining()).put(slice).flip();
    }

    private static FloatBuffer copy(FloatBuffer floats) {
        return bytes(4L * floats.remaining()).asFloatBuffer().put(floats).flip();
    }

    private static IntBuffer copy(IntBuffer ints) {
        return bytes(4L * ints.remaining()).asIntBuffer().put(ints).flip();
    }

    /** The address of a slice's first element; the buffer must stay reachable while it is used. */
    static Pointer address(Buffer slice) {
        return slice == null ? null : Native.getDirectBufferPointer(slice);
    }

    /** A copy of memory that C owns, read-only; an empty buffer for NULL. */
    static ByteBuffer copy(Pointer memory, long size) {
        ByteBuffer copy = bytes(memory == null ? 0 : size);
        if (memory != null && size > 0) {
            copy.put(memory.getByteBuffer(0, size)).flip();
        }
        return copy.asReadOnlyBuffer().order(ByteOrder.nativeOrder());
    }

    /** A slice's bytes that C may write, or an exception. */
    static ByteBuffer writable(ByteBuffer bytes) {
        if (!bytes.isDirect() || bytes.isReadOnly()) {
            throw new IllegalArgumentException(
                    "the library writes to direct, writable buffers only");
        }
        return bytes.slice().order(ByteOrder.nativeOrder());
    }

    /** Whether C can read a slice as it lies there. */
    static boolean isReadable(Buffer slice, ByteOrder order) {
        return slice.isDirect() && order == ByteOrder.nativeOrder() && isAligned(slice);
    }

    /** Floats may lie at any byte of a ByteBuffer, but not in C. */
    static boolean isAligned(Buffer slice) {
        return Pointer.nativeValue(address(slice)) % 4 == 0;
    }
}
