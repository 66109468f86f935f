/* test_file.cpp: a tree that is saved and loaded is the same tree, and what is no tree is not loaded.
 */
#include "common.hpp"

typedef std::vector<unsigned char> bytes;

static std::vector<ht::hit> hits_of(const ht::tree &tree) {
    std::vector<ht::hit> hits(soup().rays.size());
    MUST(tree.intersect(soup().rays.data(), hits.size(), hits.data()));
    return hits;
}

TEST_CASE("a saved tree comes back, of every kind") {
    for (const std::string &name : the_file().kinds) {
        CAPTURE(name);
        const ht::tree tree = good_tree(ht::options(ht::kind_from_name(name.c_str())));
        const bytes file = MUST(tree.save());
        const ht::tree back = MUST(ht::tree::load(file, ht::load_options().threads(1)));
        CHECK(name == ht::kind_name(static_cast<ht::kind>(MUST(back.view()).kind)));
        CHECK(same_bits(hits_of(back), soup().hits));
        CHECK(MUST(back.save()) == file);
        CHECK(MUST(tree.save(nullptr, 0)) == file.size());
        bytes room(file.size() + 1);
        CHECK(MUST(tree.save(room.data(), room.size())) == file.size());
        CHECK(std::memcmp(room.data(), file.data(), file.size()) == 0);
        CHECK_REFUSED(tree.save(room.data(), file.size() - 1), ht::status::argument);
    }
}

TEST_CASE("a borrowed file is not copied") {
    const ht::tree tree = good_tree();
    const std::uint64_t size = MUST(tree.save(nullptr, 0));
    bytes room(size + 64);
    unsigned char *const file =
        room.data() + (64 - reinterpret_cast<std::uintptr_t>(room.data()) % 64) % 64;
    MUST(tree.save(file, size));
    const ht::tree back = MUST(ht::tree::load(file, size, ht::load_options().borrow()));
    const ht::view view = MUST(back.view());
    const unsigned char *const nodes = static_cast<const unsigned char *>(view.nodes);
    CHECK(nodes > file);
    CHECK(nodes < file + size);
    CHECK(same_bits(hits_of(back), soup().hits));
    CHECK_REFUSED(ht::tree::load(file + 4, size - 4, ht::load_options().borrow()),
                  ht::status::argument);
}

TEST_CASE("objects need their callback again") {
    const ht::box boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{2, 0, 0}, {3, 1, 1}}};
    auto top = [](std::uint32_t object, const ht::ray &r, ht::hit &h) noexcept {
        h.t = (1 - r.org[2]) / r.dir[2];
        h.v = static_cast<float>(object);
        return true;
    };
    const ht::tree tree = MUST(ht::tree::build(ht::mesh().objects(boxes, 2, top)));
    const bytes file = MUST(tree.save());
    CHECK_REFUSED(ht::tree::load(file), ht::status::argument);
    const ht::tree back = MUST(ht::tree::load(file, ht::load_options().objects(top)));
    const ht::ray down = {{2.5f, 0.5f, 5}, 0, {0, 0, -1}, 10};
    const ht::hit hit = MUST(back.intersect(down));
    CHECK(hit.prim == 1);
    CHECK(hit.t == 4);
    CHECK(hit.v == 1);
}

TEST_CASE("what is no tree is not loaded") {
    const ht::tree tree = good_tree();
    const bytes file = MUST(tree.save());
    bytes bad = file;
    bad[file.size() / 2] ^= 1;
    CHECK_REFUSED(ht::tree::load(bad), ht::status::corrupt);
    CHECK_REFUSED(ht::tree::load(bytes()), ht::status::corrupt);
    CHECK_REFUSED(ht::tree::load(bytes(file.begin(), file.end() - 1)), ht::status::corrupt);
    CHECK_REFUSED(ht::tree::load(nullptr, 5), ht::status::argument);
    CHECK_REFUSED(ht::tree().save(), ht::status::argument);
    CHECK_REFUSED(ht::tree().save(nullptr, 0), ht::status::argument);
}
