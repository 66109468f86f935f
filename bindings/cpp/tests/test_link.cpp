/* test_link.cpp: the header in a second unit of one program, there with the other way of errors. */
#ifndef HTREE_HPP_STATUS
#define HTREE_HPP_STATUS
#endif
#include <htree.hpp>

int status_of_a_bad_build(); /* called from test_mode.cpp */

int status_of_a_bad_build() {
    const float xyz[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const ht::result<ht::tree> tree =
        ht::tree::build(ht::mesh(xyz, 3), ht::options(ht::kind::h).axes(2));
    return tree ? -1 : static_cast<int>(tree.error().code());
}
