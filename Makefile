# libhtree. `make help` lists the targets; `make config=debug check` works for any config.

config ?= release
B := build/$(config)
VERSION := 0.1.0
SONAME := libhtree.so.0

CC ?= cc
PKG_CONFIG ?= pkg-config
CLANG_FORMAT ?= clang-format
CLANG ?= clang
HAVE_CLANG := $(shell command -v $(CLANG) >/dev/null && echo yes)
# Clang's sanitizers see more than gcc's: an index beyond a member that stays within the struct, for one.
ifeq ($(config)$(origin CC)$(HAVE_CLANG),sanitizedefaultyes)
CC := $(CLANG)
endif

# ---- Flags: ours first, the user's CFLAGS CPPFLAGS LDFLAGS after them and never changed -----------
WARN := -pedantic -Wall -Wextra -Wshadow -Wconversion -Wmissing-prototypes -Wc++-compat
ifdef WERROR
WARN += -Werror
endif
OPT_release := -O3 -DNDEBUG -fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2
OPT_debug := -O1 -g
OPT_sanitize := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined,float-cast-overflow \
    -fno-sanitize-recover=all
OPT_tsan := -O1 -g -fsanitize=thread
OPT_coverage := -O0 -g --coverage -D'HT_INLINE=static inline'
ifndef OPT_$(config)
$(error config=$(config): use release, debug, sanitize, tsan or coverage)
endif
# No contraction, no fast-math: every build gives the same bits (one answer, see include/htree.h).
BASE := -std=c99 -ffp-contract=off -fvisibility=hidden -fPIC $(OPT_$(config)) $(WARN)
LINK := $(OPT_$(config)) $(LDFLAGS)
OURS_CPP := -Iinclude -MMD -MP
POSIX := -D_POSIX_C_SOURCE=200809L

ifdef V
Q :=
else
Q := @
endif
say = @printf '%-8s %s\n' $(1) $(2)

# ---- Optional packages ----------------------------------------------------------------------------
# They are looked for while this file is read, so what `make deps run` installs must be there before: make
# first remakes what a Makefile includes, and where that has changed it reads everything again.
PACKAGES := gcc make pkg-config libpng-dev libcmocka-dev libassimp-dev libwebp-dev gnuplot-nox \
    opencl-headers ocl-icd-libopencl1 pocl-opencl-icd
ifneq ($(filter deps,$(MAKECMDGOALS)),)
include build/deps.mk
build/deps.mk: FORCE
	$(Q)mkdir -p $(@D) && sh examples/deps.sh $@ $(PACKAGES)
FORCE:
endif

have = $(shell $(PKG_CONFIG) --exists $(1) 2>/dev/null && echo yes)
HAVE_PNG := $(call have,libpng)
HAVE_ASSIMP := $(call have,assimp)
HAVE_WEBP := $(call have,libwebpmux)
HAVE_MPI := $(call have,mpi-c)
HAVE_CMOCKA := $(call have,cmocka)
# A hash by itself: versions of make differ in what \# is within a call.
hash := \#
have-header = $(shell echo '$(hash)include <$(1)>' | $(CC) $(2) -E - >/dev/null 2>&1 && echo yes)
HAVE_OPENCL := $(call have-header,CL/cl.h,-DCL_TARGET_OPENCL_VERSION=120)
HAVE_EMBREE := $(call have-header,embree3/rtcore.h)

# ---- Sources: a folder is a layer, a file is a module ---------------------------------------------
LIB_SRC := $(sort $(wildcard lib/base/*.c lib/tree/*.c lib/build/*.c lib/build/*/*.c lib/trace/*.c lib/trace/*/*.c))
PARTS := mesh output picture program bart animate table1 visibility nodes
PART_SRC := $(sort $(foreach part,$(PARTS),$(wildcard examples/$(part)/*.c)))
BENCH_SRC := $(filter-out $(if $(HAVE_EMBREE),%/peer_none.c,%/peer.c %/peer_pack.c %/peer_trace.c), \
    $(sort $(wildcard examples/bench/*.c)))
PART_CPP := $(patsubst %,-Iexamples/%,$(PARTS) bench)
MOCK_TEST_SRC := $(patsubst %,tests/test_cl_%.c,arguments devices faults threads)
TEST_CL_SRC := $(if $(HAVE_OPENCL),$(filter-out $(MOCK_TEST_SRC),$(sort $(wildcard tests/test_cl*.c))))
TEST_CL_COMMON_SRC := tests/common/cl_suite.c
TEST_COMMON_SRC := $(filter-out $(TEST_CL_COMMON_SRC),$(sort $(wildcard tests/common/*.c)))
TEST_SRC := $(filter-out $(wildcard tests/test_cl*.c),$(sort $(wildcard tests/test_*.c)))
obj = $(patsubst %.c,$(B)/%.o,$(1))
LIB_OBJ := $(call obj,$(LIB_SRC))
STATIC := $(B)/libhtree.a
SHARED := $(B)/libhtree.so.$(VERSION)

# libhtree_cl: what it shares with libhtree below the public functions, it holds once more.
KERNELS := probe bvh h kd ug wide
CL_OBJ := $(call obj,$(sort $(wildcard lib/opencl/*.c))) $(B)/cl/kernels.o
CL_BASE_OBJ := $(call obj,lib/base/memory.c lib/base/progress.c lib/base/status.c)
ifeq ($(HAVE_OPENCL),yes)
CL_STATIC := $(B)/libhtree_cl.a
CL_SHARED := $(B)/libhtree_cl.so.$(VERSION)
endif
PROGRAMS := $(B)/minimal
ifeq ($(HAVE_OPENCL),yes)
PROGRAMS += $(B)/opencl
endif
ifeq ($(HAVE_PNG),yes)
PROGRAMS += $(B)/htree-render
PROGRAMS += $(B)/htree-table1 $(B)/htree-visibility
PROGRAMS += $(B)/htree-animate $(B)/htree-bench $(B)/htree-nodes
ifeq ($(HAVE_MPI),yes)
PROGRAMS += $(B)/htree-mpi-render
endif
endif
CL_TESTS := $(patsubst tests/%.c,$(B)/tests/%,$(TEST_CL_SRC))
ifeq ($(HAVE_OPENCL)$(HAVE_CLANG),yesyes)
MOCK := $(B)/tests/mock/libOpenCL.so.1
MOCK_TESTS := $(patsubst tests/%.c,$(B)/tests/%,$(MOCK_TEST_SRC))
endif
TESTS := $(patsubst tests/%.c,$(B)/tests/%,$(TEST_SRC)) $(CL_TESTS) $(MOCK_TESTS) \
    $(if $(HAVE_OPENCL),$(B)/tests/cl_compare)

.DEFAULT_GOAL := all
.SUFFIXES:
.SECONDARY:
.DELETE_ON_ERROR:

all: $(STATIC) $(SHARED) $(CL_STATIC) $(CL_SHARED) $(PROGRAMS) ## build the library and the programs into build/$(config)
ifneq ($(HAVE_PNG),yes)
	@echo "skipped htree-render: libpng is missing (make deps, or apt-get install libpng-dev)"
endif
ifneq ($(HAVE_OPENCL),yes)
	@echo "skipped libhtree_cl: OpenCL headers are missing (make deps, or apt-get install opencl-headers)"
endif
ifneq ($(HAVE_ASSIMP),yes)
	@echo "note: htree-render reads PLY only: assimp is missing (apt-get install libassimp-dev)"
endif
ifneq ($(HAVE_WEBP),yes)
	@echo "note: htree-animate writes no WebP: libwebp is missing (apt-get install libwebp-dev)"
endif

lib: $(STATIC) $(SHARED) $(CL_STATIC) $(CL_SHARED) ## the library alone: needs a C compiler and nothing else

# ---- Compile --------------------------------------------------------------------------------------
$(B)/lib/%.o: lib/%.c Makefile
	$(call say,CC,$<)
	@mkdir -p $(@D)
	$(Q)$(CC) $(BASE) $(OURS_CPP) $(POSIX) -Ilib -DHTREE_BUILDING $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

# Kernels travel inside the library, each as one array of bytes, as they are in cl/.
$(B)/cl/kernels.c: cl/embed.sh lib/tree/layout.h cl/common.cl $(KERNELS:%=cl/%.cl)
	$(call say,EMBED,cl/)
	@mkdir -p $(@D)
	$(Q)sh cl/embed.sh $(KERNELS) >$@

$(B)/cl/kernels.o: $(B)/cl/kernels.c
	$(call say,CC,$<)
	$(Q)$(CC) $(BASE) $(OURS_CPP) -Ilib $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

PNG_CFLAGS := $(if $(HAVE_PNG),$(shell $(PKG_CONFIG) --cflags libpng))
PNG_LIBS := $(if $(HAVE_PNG),$(shell $(PKG_CONFIG) --libs libpng))
ASSIMP_CFLAGS := $(if $(HAVE_ASSIMP),-DHAVE_ASSIMP $(shell $(PKG_CONFIG) --cflags assimp))
ASSIMP_LIBS := $(if $(HAVE_ASSIMP),$(shell $(PKG_CONFIG) --libs assimp))
WEBP_CFLAGS := $(if $(HAVE_WEBP),-DHAVE_WEBP $(shell $(PKG_CONFIG) --cflags libwebpmux libwebp))
WEBP_LIBS := $(if $(HAVE_WEBP),$(shell $(PKG_CONFIG) --libs libwebpmux libwebp))
OPENCL_CFLAGS := $(if $(HAVE_OPENCL),-DHAVE_OPENCL)
OPENCL_LIBS := $(if $(HAVE_OPENCL),-ldl)
EMBREE_LIBS := $(if $(HAVE_EMBREE),-lembree3)

$(B)/examples/%.o: examples/%.c Makefile
	$(call say,CC,$<)
	@mkdir -p $(@D)
	$(Q)$(CC) $(BASE) $(OURS_CPP) $(POSIX) $(PART_CPP) $(PNG_CFLAGS) $(ASSIMP_CFLAGS) \
	    $(WEBP_CFLAGS) $(OPENCL_CFLAGS) $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

# Nodes are looked at where they lie.
$(B)/examples/nodes/%.o: PART_CPP += -Ilib/tree

# White-box tests may see the internal headers, so tests link the static library.
$(B)/tests/%.o: tests/%.c Makefile
	$(call say,CC,$<)
	@mkdir -p $(@D)
	$(Q)$(CC) $(BASE) $(OURS_CPP) $(POSIX) -Ilib $(PART_CPP) -Itests/common -Itests/fuzz \
	    -Itests/mock \
	    $(CPPFLAGS) $(CFLAGS) -c -o $@ $<

# ---- Link -----------------------------------------------------------------------------------------
$(STATIC): $(LIB_OBJ)
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AR) rcs $@ $^

$(SHARED): $(LIB_OBJ) lib/htree.map
	$(call say,LINK,$@)
	$(Q)$(CC) -shared -Wl,-soname,$(SONAME) -Wl,--version-script=lib/htree.map -Wl,-z,relro,-z,now \
	    $(LINK) -o $@ $(LIB_OBJ) -lm -lpthread
	$(Q)ln -sf $(@F) $(B)/$(SONAME) && ln -sf $(SONAME) $(B)/libhtree.so

$(B)/libhtree_cl.a: $(CL_OBJ)
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AR) rcs $@ $^

$(B)/libhtree_cl.so.$(VERSION): $(CL_OBJ) $(CL_BASE_OBJ) $(SHARED) lib/htree_cl.map
	$(call say,LINK,$@)
	$(Q)$(CC) -shared -Wl,-soname,libhtree_cl.so.0 -Wl,--version-script=lib/htree_cl.map \
	    -Wl,-z,relro,-z,now $(LINK) -o $@ $(CL_OBJ) $(CL_BASE_OBJ) -L$(B) -lhtree -lpthread -ldl
	$(Q)ln -sf $(@F) $(B)/libhtree_cl.so.0 && ln -sf libhtree_cl.so.0 $(B)/libhtree_cl.so

$(B)/minimal: $(B)/examples/minimal.o $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $^ -lm -lpthread

$(B)/opencl: $(B)/examples/opencl.o $(CL_STATIC) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $^ -lm -lpthread $(OPENCL_LIBS)

$(B)/htree-%: $(B)/examples/%.o $(call obj,$(PART_SRC)) $(CL_STATIC) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(MORE_LIBS) \
	    $(PNG_LIBS) $(ASSIMP_LIBS) $(WEBP_LIBS) -lm -lpthread $(OPENCL_LIBS)

# The other programs must not need MPI, nor what the benchmark compares with.
MPI_CFLAGS := $(if $(HAVE_MPI),$(patsubst -I%,-isystem %,$(shell $(PKG_CONFIG) --cflags mpi-c)))
$(B)/examples/mpi_render.o: PART_CPP += $(MPI_CFLAGS)
$(B)/htree-mpi-render: MORE_LIBS := $(if $(HAVE_MPI),$(shell $(PKG_CONFIG) --libs mpi-c))
$(B)/htree-mpi-render: $(B)/examples/mpi_render.o $(call obj,$(PART_SRC)) $(CL_STATIC) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(MORE_LIBS) \
	    $(PNG_LIBS) $(ASSIMP_LIBS) $(WEBP_LIBS) -lm -lpthread $(OPENCL_LIBS)

$(B)/htree-bench: $(call obj,$(BENCH_SRC))
$(B)/htree-bench: MORE_LIBS := $(EMBREE_LIBS)

# Of the examples, tests link what needs nothing but libc and libm.
TEST_EXAMPLE_SRC := $(sort $(wildcard examples/bart/*.c)) examples/picture/camera.c \
    examples/program/loop.c \
    $(patsubst %,examples/mesh/%.c,decimal ply ply_header shapes subdivide)
$(CL_TESTS): $(B)/tests/%: $(B)/tests/%.o $(call obj,$(TEST_CL_COMMON_SRC)) \
    $(call obj,$(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(CL_STATIC) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $(filter %.o %.a,$^) -lcmocka -lm -lpthread -ldl

# The mock is the OpenCL of the programs that link it: whoever opens libOpenCL.so.1 by that name gets what
# is loaded already. Its kernels are those of cl/, compiled for this machine.
MOCK_KERNEL_FLAGS := -O2
ifeq ($(config),sanitize)
MOCK_KERNEL_FLAGS := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all
endif
$(B)/tests/mock/kernels.o: tests/mock/kernels.sh tests/mock/mock_inner.h tests/mock/mock_cl.h \
    lib/tree/layout.h cl/common.cl $(KERNELS:%=cl/%.cl)
	$(call say,KERNELS,$@)
	@mkdir -p $(@D)
	$(Q)sh tests/mock/kernels.sh $@ $(CLANG) "$(MOCK_KERNEL_FLAGS)" $(KERNELS)

$(B)/tests/mock/libOpenCL.so.1: $(call obj,$(sort $(wildcard tests/mock/mock_*.c))) $(B)/tests/mock/kernels.o
	$(call say,LINK,$@)
	$(Q)$(CC) -shared -Wl,-soname,$(@F) $(LINK) -o $@ $^ -lm -lpthread

$(B)/tests/mock/lacking/libOpenCL.so.1: $(B)/tests/mock/lacking.o
	$(call say,LINK,$@)
	@mkdir -p $(@D)
	$(Q)$(CC) -shared -Wl,-soname,$(@F) -o $@ $^
$(B)/tests/test_cl_processes: $(B)/tests/mock/lacking/libOpenCL.so.1

$(B)/tests/cl_compare: $(B)/tests/cl_compare.o $(call obj,$(TEST_CL_COMMON_SRC)) \
    $(call obj,$(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(CL_STATIC) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -Wl,--wrap=ht_cl_prove -o $@ $^ -lcmocka -lm -lpthread -ldl

$(MOCK_TESTS): $(B)/tests/%: $(B)/tests/%.o $(call obj,$(patsubst %,tests/mock/%.c,rig bench memo)) \
    $(call obj,$(TEST_CL_COMMON_SRC) $(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(CL_STATIC) $(STATIC) $(MOCK)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -Wl,-rpath,'$$ORIGIN/mock' -Wl,--wrap=htree_intersect -o $@ $^ -lcmocka -lm -lpthread -ldl

FUZZ_SRC := $(filter-out %/libfuzzer.c,$(sort $(wildcard tests/fuzz/*.c)))
$(B)/tests/test_fuzz: $(call obj,$(FUZZ_SRC))

$(B)/tests/test_%: $(B)/tests/test_%.o $(call obj,$(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) $(WRAP) -o $@ $(filter %.o %.a,$^) -lcmocka -lm -lpthread

# Threads that cannot be started.
$(B)/tests/test_threads: WRAP := -Wl,--wrap=pthread_create

$(B)/soak: $(B)/tests/soak.o $(call obj,$(FUZZ_SRC) $(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $^ -lcmocka -lm -lpthread

# ---- Run ------------------------------------------------------------------------------------------
OUT := $(B)/out

run: all ## render the gallery (or MESH=path) and its heat maps into build/$(config)/out
	@mkdir -p $(OUT)
	$(Q)sh examples/gallery.sh $(B)/htree-render $(OUT) $(MESH)

bench: all ## time every kind on the built-in scenes (or MESH=path)
	$(Q)sh tests/bench/bench.sh $(B)/htree-render $(OUT) $(MESH)

bench-device: all ## time kinds on the CPU, on an OpenCL device (DEVICE=name) and in Embree (MESH=path)
	@mkdir -p $(OUT)
	$(Q)$(B)/htree-bench --kind wide,h,bvh-sah --device "$(or $(DEVICE),default)" \
	    $(if $(HAVE_EMBREE),--peer embree) \
	    --json $(OUT)/bench-device.json $(MESH) >$(OUT)/bench-device.txt
	@cat $(OUT)/bench-device.txt

# KINDS, PEERS and THREADS replace the lists; SCENE adds built-in scenes, such as terrain:10000000; FLAGS adds
# options of htree-bench.
KINDS ?= fast,balanced,best,fast+lazy,balanced+compact
QUICK_PEERS := embree-low,embree-low-robust,embree-refit,embree-refit-robust
PEERS ?= $(QUICK_PEERS),embree-medium,embree-medium-robust,embree-medium-compact,embree-high,embree-high-robust
THREADS ?= 1,0
RESULT ?= bench-peers
bench-peers: all ## builds, rays and T_T beside Embree's, as docs/results/bench-peers.txt (MESH=path, SCENE=name)
	@mkdir -p $(OUT)
	$(Q)$(B)/htree-bench --threads $(THREADS) --kind $(KINDS) $(if $(HAVE_EMBREE),--peer $(PEERS)) $(FLAGS) \
	    --json $(OUT)/$(RESULT).json $(SCENE:%=--scene %) $(MESH) >$(OUT)/$(RESULT).txt
	@cat $(OUT)/$(RESULT).txt
	@cp $(OUT)/$(RESULT).txt docs/results/
ifneq ($(HAVE_EMBREE),yes)
	@echo "note: Embree is not in it (apt-get install libembree-dev)"
endif

bench-large: ## the same for a surface of 10^7 triangles, as docs/results/bench-large.txt: 8 GB, a quarter of an hour
	$(Q)$(MAKE) --no-print-directory bench-peers RESULT=bench-large SCENE=terrain:10000000 KINDS=fast,balanced,fast+lazy \
	    PEERS=embree-low,embree-medium,embree-refit FLAGS='--rounds 3 --seconds 0'

bench-rust: all ## builds and rays beside those of other Rust crates, as docs/results/bench-rust.txt (MESH=path)
	@mkdir -p $(OUT)
	$(Q)sh bindings/rust/peers/bench.sh $(B) $(OUT) $(MESH)
	@cat $(OUT)/bench-rust.txt
	@cp $(OUT)/bench-rust.txt docs/results/

table1: all ## the paper's Table 1 with its figures beside ours, over the meshes in HTREE_SCENES
	@mkdir -p $(OUT)
	$(Q)$(B)/htree-table1 --json $(OUT)/table1.json --csv $(OUT)/table1.csv >$(OUT)/table1.txt
	@cat $(OUT)/table1.txt

plots: all ## plots of growth, times, heat maps and precision, by gnuplot, after table1
	$(Q)sh examples/plots.sh $(B)/htree-table1 $(B)/htree-render $(OUT)

# ---- Check ----------------------------------------------------------------------------------------
tests: $(TESTS) ## build the test programs
ifneq ($(HAVE_CMOCKA),yes)
	@echo "error: the tests need cmocka (make deps, or apt-get install libcmocka-dev)" && exit 1
endif
ifneq ($(HAVE_OPENCL)$(HAVE_CLANG),yesyes)
	@echo "skipped $(MOCK_TEST_SRC:tests/%.c=%): they need clang and opencl-headers (apt-get install both)"
	@test "$$HTREE_REQUIRE_ALL" != 1
endif

test: all tests ## run the test programs of this config
	$(Q)sh tests/run.sh $(config)

check: all tests ## everything: this config, ASan+UBSan, TSan, layers, headers, symbols
	$(Q)$(MAKE) --no-print-directory config=release lib
	$(Q)$(MAKE) --no-print-directory config=sanitize tests
	$(Q)$(MAKE) --no-print-directory config=tsan tests
	$(Q)CC="$(CC)" sh tests/run.sh $(config) sanitize tsan kernels oclgrind arm bench house abi install onefile dist docs messages mpi gallery

check-arm: ## the library for 64-bit ARM, cross-compiled and run by QEMU
	$(Q)sh tests/arm.sh

check-fresh: ## README.md's commands in a Debian that has git and make alone (FOLDER=path, FULL=1); as root
	$(Q)sh tests/fresh_root.sh $(or $(FOLDER),build/fresh)

# By clang, in a folder of its own; the targets share all objects but libFuzzer's door.
FUZZ_TARGETS := ply aff tree scene api
FUZZ := $(patsubst %,build/fuzz/fuzz_%,$(FUZZ_TARGETS))
FUZZ_OBJ := $(patsubst %.c,build/fuzz/%.o,$(FUZZ_SRC) $(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC) $(LIB_SRC))
FUZZ_FLAGS := -O1 -g -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all
FUZZ_CC = $(CLANG) -std=c99 -ffp-contract=off $(FUZZ_FLAGS) $(OURS_CPP) $(POSIX) -Ilib $(PART_CPP) \
    -Itests/common -Itests/fuzz
build/fuzz/%.o: %.c Makefile
	$(call say,FUZZ,$<)
	@mkdir -p $(@D)
	$(Q)$(FUZZ_CC) -fsanitize=fuzzer-no-link -c -o $@ $<

build/fuzz/fuzz_%: tests/fuzz/libfuzzer.c $(FUZZ_OBJ)
	$(call say,LINK,$@)
	$(Q)$(FUZZ_CC:-M%=) -fsanitize=fuzzer -DFUZZ_TARGET=fuzz_$* -o $@ $^ -lcmocka -lm -lpthread

.PHONY: fuzz
fuzz: $(FUZZ) ## fuzz every reader, tree files, scenes and calls by libFuzzer, SECONDS=60 each
	$(Q)sh tests/fuzz.sh build/fuzz $(or $(SECONDS),60) $(TARGETS)

.PHONY: soak mutants
soak: $(B)/soak ## the tests with new seeds for HOURS=2, going on where the last soak ended; log in build/soak
	@mkdir -p build/soak
	$(Q)$(B)/soak build/soak $$(($(or $(HOURS),2) * 3600))

mutants: ## tests of the tests: known bugs are put in one by one, and must be caught
	$(Q)sh tests/mutants.sh $(MUTANTS)

.PHONY: coverage
coverage: ## lines and branches of lib/ that the tests run; what they do not lies in build/coverage/uncovered
	$(Q)$(MAKE) --no-print-directory config=coverage tests
	$(Q)sh tests/coverage.sh

layers: ## check the include law and the map of lib/README.md
	$(Q)sh tests/layers.sh

# ---- Bindings -------------------------------------------------------------------------------------
include bindings/bindings.mk

# ---- Install --------------------------------------------------------------------------------------
include packaging/install.mk
include packaging/dist.mk

# ---- Documentation --------------------------------------------------------------------------------
include docs/docs.mk

# ---- House ----------------------------------------------------------------------------------------
FORMATTED = $(shell git ls-files '*.[ch]' '*.cl' '*.hpp' '*.cpp' 2>/dev/null)
format: ## format all C sources in place
	$(Q)$(CLANG_FORMAT) -i $(FORMATTED)

deps: ## install the Debian packages that are missing
	@:

print-packages:
	@echo $(PACKAGES)

clean: ## remove build/ and dist/
	rm -rf build dist

help: ## this list
	@echo "make [config=release|debug|sanitize|tsan|coverage] [V=1] [WERROR=1] TARGET"
	@sed -n 's/^\([a-z0-9-]*\):.*## \(.*\)/  \1\t\2/p' $(filter-out %.d,$(MAKEFILE_LIST)) | expand -t 18

.PHONY: print-packages all lib run bench bench-device bench-peers bench-rust bench-large table1 plots tests test check check-arm check-fresh layers format deps install uninstall clean help

-include $(shell find $(B) build/fuzz -name '*.d' 2>/dev/null)
