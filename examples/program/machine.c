/* machine.c: figures mean nothing without the machine and the command. */
#include "machine.h"

#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#if defined(__clang__)
#define COMPILER "clang " __clang_version__
#elif defined(__GNUC__)
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "an unknown compiler"
#endif

/* The first "model name : ..." of /proc/cpuinfo, where there is one. */
static void describe_processor(char *out, size_t size) {
    char line[256];
    FILE *file = fopen("/proc/cpuinfo", "r");
    snprintf(out, size, "unknown processor");
    while (file && fgets(line, sizeof line, file)) {
        const char *colon = strstr(line, ": ");
        if (strncmp(line, "model name", 10) != 0 || !colon) continue;
        snprintf(out, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
        break;
    }
    if (file) fclose(file);
}

void machine_describe(char *out, size_t size) {
    char processor[160];
    struct utsname system;
    describe_processor(processor, sizeof processor);
    if (uname(&system) != 0) memset(&system, 0, sizeof system);
    snprintf(out, size, "%s, %ld cores, %s %s, %s", processor, sysconf(_SC_NPROCESSORS_ONLN),
             system.sysname, system.machine, COMPILER);
}

void machine_command(char *out, size_t size, int argc, char *const *argv) {
    size_t used = 0;
    for (int i = 0; i < argc && used + 1 < size; ++i) {
        const char *slash = strrchr(argv[i], '/');
        const char *word = slash && slash[1] ? slash + 1 : argv[i];
        const char *quote = strpbrk(word, " \t'\"\\$&|;<>()*?") || !*word ? "'" : "";
        const int more =
            snprintf(out + used, size - used, "%s%s%s%s", i ? " " : "", quote, word, quote);
        used += more > 0 ? (size_t)more : 0;
    }
}
