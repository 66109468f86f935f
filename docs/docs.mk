# docs.mk: drawings, reference and gallery of docs/. The Makefile of the root includes it.

DRAWN := ug kd bvh-sah skd h ah wide

$(B)/docs/draw: docs/drawings/draw.c $(STATIC)
	$(call say,LINK,$@)
	@mkdir -p $(@D)
	$(Q)$(CC) $(BASE) -Iinclude -Ilib/tree $(CPPFLAGS) $(CFLAGS) $(LINK) -o $@ $^ -lm -lpthread

drawings: $(B)/docs/draw ## draw the trees of docs/structures.md
	$(Q)for kind in $(DRAWN); do $(B)/docs/draw $$kind >docs/drawings/$$kind.svg || exit 1; done

reference: ## pages of the headers by doxygen: build/reference/html
	@mkdir -p build/reference
	$(Q)(cat docs/Doxyfile; echo "PROJECT_NUMBER = $(VERSION)"; echo "OUTPUT_DIRECTORY = build/reference"; \
	    echo "WARN_AS_ERROR = FAIL_ON_WARNINGS") | doxygen -

gallery: all ## pictures, heat maps, films and a tree viewer as a static site: build/gallery/index.html
	$(Q)sh docs/gallery/make.sh $(B) build/gallery

readme-figures: ## take the figures of README.md, and of Rust's, anew from docs/results
	$(Q)for page in README.md bindings/rust/README.md; do \
	    sh docs/figures.sh $$page >build/README.md && cp build/README.md $$page || exit 1; done

.PHONY: drawings reference gallery readme-figures
