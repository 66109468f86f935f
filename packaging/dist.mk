# dist.mk: the sources as one archive, and the library as one file. The Makefile of the root includes it.

# ---- Archive --------------------------------------------------------------------------------------

ARCHIVE := dist/libhtree-$(VERSION).tar.gz

# What git knows, as it is here; the same bytes whoever packs it, from one commit.
dist: ## the sources as an archive: dist/libhtree-$(VERSION).tar.gz
	$(call say,TAR,$(ARCHIVE))
	@mkdir -p dist
	$(Q)git ls-files | LC_ALL=C sort | tar --create --file=- --files-from=- --owner=0 --group=0 \
	    --numeric-owner --mtime=@$$(git log -1 --format=%ct) --mode=u+w,go=rX \
	    --transform='s,^,libhtree-$(VERSION)/,' | gzip -9n >$(ARCHIVE)

distcheck: dist ## unpack that archive elsewhere, build, test and install it there
	$(Q)CC="$(CC)" sh tests/run.sh dist

deb: dist ## Debian packages of that archive: dist/*.deb
	$(Q)sh packaging/deb.sh $(VERSION)

# ---- One file -------------------------------------------------------------------------------------

LAYERED_SRC := $(foreach layer,base tree build trace,$(filter lib/$(layer)/%,$(LIB_SRC)))

dist/htree.c: packaging/amalgamate.sh $(LIB_SRC) $(wildcard lib/*/*.h lib/*/*/*.h) LICENSE
	$(call say,ONE,$@)
	@mkdir -p $(@D)
	$(Q)sh packaging/amalgamate.sh $(VERSION) $(LAYERED_SRC) >$@

dist/htree.h: include/htree.h
	@mkdir -p $(@D)
	$(Q)cp $< $@

amalgamation: dist/htree.c dist/htree.h ## the library as one file: dist/htree.c and dist/htree.h

# The test programs once more, over the one file: without threads and as GNU C, where compilers may contract,
# in single_*. It gets no flag of ours but warnings: whoever takes the file has none either.
ONE_WARN := -pedantic -Wall -Wextra -Wconversion -Wmissing-prototypes -Wno-unknown-pragmas -Werror
$(B)/onefile/htree.o: dist/htree.c dist/htree.h
	$(call say,CC,$<)
	@mkdir -p $(@D)
	$(Q)$(CC) -std=c99 -O3 $(ONE_WARN) -c -o $@ $<

$(B)/onefile/single.o: dist/htree.c dist/htree.h
	$(call say,CC,$<)
	@mkdir -p $(@D)
	$(Q)$(CC) -std=gnu11 -O3 $(ONE_WARN) -DHTREE_NO_THREADS -c -o $@ $<

$(B)/onefile/test_%: $(B)/tests/test_%.o $(call obj,$(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(B)/onefile/htree.o
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) $(WRAP) -o $@ $^ -lcmocka -lm -lpthread

$(B)/onefile/test_fuzz: $(call obj,$(FUZZ_SRC))
$(B)/onefile/test_threads: WRAP := -Wl,--wrap=pthread_create

$(B)/onefile/single_%: $(B)/tests/test_%.o $(call obj,$(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(B)/onefile/single.o
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $^ -lcmocka -lm -lpthread

.PHONY: dist distcheck deb amalgamation
