# install.mk: what a machine gets by `make install`, and how it is found there. The Makefile of the root
# includes it. Directories are GNU's: set PREFIX, or any of them alone.

PREFIX ?= /usr/local
DESTDIR ?=
prefix ?= $(PREFIX)
exec_prefix ?= $(prefix)
bindir ?= $(exec_prefix)/bin
libdir ?= $(exec_prefix)/lib
includedir ?= $(prefix)/include
datarootdir ?= $(prefix)/share
mandir ?= $(datarootdir)/man
docdir ?= $(datarootdir)/doc/libhtree
pkgconfigdir ?= $(libdir)/pkgconfig
cmakedir ?= $(libdir)/cmake/htree
completionsdir ?= $(datarootdir)/bash-completion/completions
INSTALL ?= install
INSTALL_PROGRAM ?= $(INSTALL)
INSTALL_DATA ?= $(INSTALL) -m 644

# Programs are installed with a page of the manual, so those without one are not.
INSTALLED := $(filter $(patsubst packaging/man/%.1,$(B)/%,$(wildcard packaging/man/*.1)),$(PROGRAMS))
CL_HERE := $(if $(CL_SHARED),yes)

# The files of a CMake package reach the prefix by as many steps up as there are folders below it, and
# so find their neighbours wherever the whole is moved to.
below = $(patsubst $(prefix)/%,%,$(1))
up = $(subst $() ,/,$(patsubst %,..,$(subst /, ,$(call below,$(1)))))
fill = sed -e 's|@version@|$(VERSION)|g' -e 's|@prefix@|$(prefix)|g' \
    -e 's|@libdir@|$(patsubst $(prefix)/%,$${prefix}/%,$(libdir))|g' \
    -e 's|@includedir@|$(patsubst $(prefix)/%,$${prefix}/%,$(includedir))|g' \
    -e 's|@up@|$(call up,$(cmakedir))|g' -e 's|@lib@|$(call below,$(libdir))|g' \
    -e 's|@include@|$(call below,$(includedir))|g'

# link-library NAME: the static library, and the three names of the shared one.
define link-library
	$(INSTALL_PROGRAM) -m 755 $(B)/$(1).so.$(VERSION) $(DESTDIR)$(libdir)/
	ln -sf $(1).so.$(VERSION) $(DESTDIR)$(libdir)/$(1).so.0
	ln -sf $(1).so.0 $(DESTDIR)$(libdir)/$(1).so
	$(INSTALL_DATA) $(B)/$(1).a $(DESTDIR)$(libdir)/
endef

# install-data DIRECTORY,FILES
define install-data
	$(INSTALL) -d $(DESTDIR)$(1)
	$(INSTALL_DATA) $(2) $(DESTDIR)$(1)/
endef

install: $(STATIC) $(SHARED) $(CL_STATIC) $(CL_SHARED) $(INSTALLED) ## install under $(DESTDIR)$(PREFIX), in GNU's directories
	$(call install-data,$(includedir),include/htree.h bindings/cpp/include/htree.hpp)
	$(call install-data,$(includedir)/htree,bindings/cpp/include/htree/*.hpp)
	$(INSTALL) -d $(DESTDIR)$(libdir) $(DESTDIR)$(pkgconfigdir) $(DESTDIR)$(cmakedir)
	$(call link-library,libhtree)
	$(fill) packaging/pkgconfig/htree.pc.in >$(DESTDIR)$(pkgconfigdir)/htree.pc
	$(fill) packaging/cmake/htree-config.cmake.in >$(DESTDIR)$(cmakedir)/htree-config.cmake
	$(fill) packaging/cmake/htree-config-version.cmake.in \
	    >$(DESTDIR)$(cmakedir)/htree-config-version.cmake
	$(call install-data,$(mandir)/man3,packaging/man/htree.3)
	$(call install-data,$(docdir),README.md CHANGELOG.md LICENSE)
	$(call install-data,$(docdir)/examples,examples/minimal.c)
ifneq ($(CL_HERE),)
	$(INSTALL_DATA) include/htree_cl.h $(DESTDIR)$(includedir)/
	$(call link-library,libhtree_cl)
	$(fill) packaging/pkgconfig/htree-cl.pc.in >$(DESTDIR)$(pkgconfigdir)/htree-cl.pc
	$(INSTALL_DATA) examples/opencl.c $(DESTDIR)$(docdir)/examples/
endif
ifneq ($(INSTALLED),)
	$(INSTALL) -d $(DESTDIR)$(bindir)
	$(INSTALL_PROGRAM) -m 755 $(INSTALLED) $(DESTDIR)$(bindir)/
	$(call install-data,$(mandir)/man1,$(patsubst $(B)/%,packaging/man/%.1,$(INSTALLED)))
	$(call install-data,$(completionsdir),$(patsubst $(B)/%,packaging/completion/%,$(INSTALLED)))
endif

install-strip: ## the same, without symbols that only debuggers read
	$(Q)$(MAKE) --no-print-directory install INSTALL_PROGRAM='$(INSTALL_PROGRAM) -s'

uninstall: ## remove what install put there
	rm -f $(patsubst %,$(DESTDIR)$(includedir)/%,htree.h htree_cl.h htree.hpp)
	rm -f $(patsubst %,$(DESTDIR)$(libdir)/%,$(foreach l,libhtree libhtree_cl,\
	    $(l).a $(l).so $(l).so.0 $(l).so.$(VERSION)))
	rm -f $(DESTDIR)$(pkgconfigdir)/htree.pc $(DESTDIR)$(pkgconfigdir)/htree-cl.pc
	rm -f $(patsubst packaging/man/%.1,$(DESTDIR)$(bindir)/%,$(wildcard packaging/man/*.1))
	rm -f $(patsubst packaging/man/%.1,$(DESTDIR)$(completionsdir)/%,$(wildcard packaging/man/*.1))
	rm -f $(patsubst packaging/man/%,$(DESTDIR)$(mandir)/man1/%,$(wildcard packaging/man/*.1))
	rm -f $(DESTDIR)$(mandir)/man3/htree.3
	rm -rf $(DESTDIR)$(includedir)/htree $(DESTDIR)$(cmakedir) $(DESTDIR)$(docdir)

installcheck: $(STATIC) $(SHARED) $(CL_STATIC) $(CL_SHARED) $(INSTALLED) ## install into build/, move it, and build the examples against it
	$(Q)CC="$(CC)" sh tests/run.sh install

.PHONY: install install-strip uninstall installcheck
