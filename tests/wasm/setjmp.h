/* setjmp.h: cmocka wants it included, and WebAssembly has none. */
