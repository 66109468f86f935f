/* test_mode.cpp: what each way of errors promises. */
#include "common.hpp"

int status_of_a_bad_build(); /* test_link.cpp, always by status */

static const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

TEST_CASE("both ways of errors live in one program") {
    CHECK(status_of_a_bad_build() == HTREE_ERROR_ARGUMENT);
}

#ifdef HTREE_HPP_STATUS

TEST_CASE("a result is a value or an error") {
    ht::result<ht::tree> good = ht::tree::build(ht::mesh(xyz, 3));
    REQUIRE(good);
    CHECK(good.error().code() == ht::status::ok);
    CHECK(*good);
    const ht::result<ht::box> bounds = good->bounds();
    REQUIRE(bounds);
    CHECK((*bounds).hi[0] == 1.0f);
    const ht::tree mine = std::move(*good);
    CHECK(mine);

    ht::result<ht::tree> bad = ht::tree::build(ht::mesh(xyz, 3), ht::options().axes(2));
    CHECK_FALSE(bad);
    CHECK_FALSE(*bad);
    CHECK(bad.error().code() == ht::status::argument);
    CHECK(std::string(bad.error().name()) == "bad argument");
    const ht::result<void> asked = bad->check();
    CHECK_FALSE(asked);
}

#else

TEST_CASE("an error is a std::exception with code, name and sentence") {
    bool caught = false;
    try {
        ht::tree::build(ht::mesh(xyz, 3), ht::options().axes(2));
    } catch (const std::exception &e) {
        caught = std::strstr(e.what(), "axes") != nullptr;
    }
    CHECK(caught);
    try {
        ht::tree().check();
        CHECK(false);
    } catch (const ht::error &e) {
        CHECK(e.code() == ht::status::argument);
        CHECK(std::string(e.name()) == "bad argument");
    }
}

#endif
