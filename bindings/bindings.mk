# bindings.mk: the conformance file and the tests of the bindings. The Makefile of the root includes it.
#
# BINDINGS names those to test, all by default; HTREE_REQUIRE_ALL=1 makes a skipped one a failure.

CONFORMANCE := $(B)/conformance.json
BINDINGS ?=

$(B)/conformance: $(call obj,$(sort $(wildcard tests/conformance/*.c)) $(TEST_COMMON_SRC) $(TEST_EXAMPLE_SRC)) $(STATIC)
	$(call say,LINK,$@)
	$(Q)$(CC) $(LINK) -o $@ $^ -lcmocka -lm -lpthread

# The program writes the file only after it has checked every answer in it.
$(CONFORMANCE): $(B)/conformance
	$(call say,RUN,$@)
	$(Q)$(B)/conformance $@

conformance: $(CONFORMANCE) ## write the conformance file, which the tests of all bindings read

bindings: $(STATIC) $(SHARED) $(CONFORMANCE) bindings-check ## test every binding whose tools are here
	$(Q)HTREE_LIB_DIR="$(CURDIR)/$(B)" HTREE_CONFORMANCE="$(CURDIR)/$(CONFORMANCE)" \
	    sh bindings/run.sh $(BINDINGS)

bindings-check: ## check that every binding has every function of htree.h
	$(Q)sh bindings/parity.sh

.PHONY: conformance bindings bindings-check
