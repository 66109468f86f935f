/* main.cpp: the test runner, and the reader of the conformance file. */
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "common.hpp"

#include <nlohmann/json.hpp>

#include <fstream>
#include <iostream>

using nlohmann::json;

static float float_of(std::uint32_t bits) {
    float x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}

/* Structs of 32-bit words, from their words. */
template <class T> static std::vector<T> structs_of(const json &array) {
    const std::vector<std::uint32_t> words = array.get<std::vector<std::uint32_t>>();
    std::vector<T> out(words.size() * 4 / sizeof(T));
    if (!out.empty()) std::memcpy(out.data(), words.data(), words.size() * 4);
    return out;
}

static scene scene_of(const json &from) {
    scene s;
    s.name = from.at("name").get<std::string>();
    for (const json &bits : from.at("positions"))
        s.xyz.push_back(float_of(bits.get<std::uint32_t>()));
    s.indexed = !from.at("indices").is_null();
    if (s.indexed) s.abc = from.at("indices").get<std::vector<std::uint32_t>>();
    s.bounds = structs_of<ht::box>(from.at("bounds")).at(0);
    const json &stats = from.at("stats");
    s.triangles = stats.at("triangles").get<std::uint64_t>();
    s.objects = stats.at("objects").get<std::uint64_t>();
    s.invalid = stats.at("invalid").get<std::uint64_t>();
    s.degenerate = stats.at("degenerate").get<std::uint64_t>();
    s.rays = structs_of<ht::ray>(from.at("rays"));
    s.hits = structs_of<ht::hit>(from.at("hits"));
    s.occluded = from.at("occluded").get<std::vector<std::uint8_t>>();
    return s;
}

static conformance read_file(const char *path) {
    std::ifstream in(path == nullptr ? "" : path);
    if (!in) {
        std::cerr << "set HTREE_CONFORMANCE to the file that `make conformance` writes\n";
        std::exit(1);
    }
    const json from = json::parse(in);
    if (from.at("format").get<int>() != 1) {
        std::cerr << "this test reads format 1 of the conformance file\n";
        std::exit(1);
    }
    conformance c;
    c.library = from.at("library").get<std::string>();
    for (const json &s : from.at("scenes")) c.scenes.push_back(scene_of(s));
    c.kinds = from.at("kinds").get<std::vector<std::string>>();
    c.statuses = from.at("statuses").get<std::map<std::string, int>>();
    for (const auto &name : from.at("status_names").items())
        c.status_names[std::stoi(name.key())] = name.value().get<std::string>();
    for (const json &m : from.at("misuse"))
        c.misuse.emplace_back(m.at("case").get<std::string>(), m.at("status").get<std::string>());
    return c;
}

const conformance &the_file() {
    static const conformance file = read_file(std::getenv("HTREE_CONFORMANCE"));
    return file;
}
