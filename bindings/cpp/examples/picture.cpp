// picture.cpp: a torus on a floor, made in code, shaded by its normals and by a lamp's shadow.
//
//     picture OUT.ppm [KIND]
#include <htree.hpp>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace {

struct vec {
    float x, y, z;
};

vec operator+(vec a, vec b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
vec operator-(vec a, vec b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
vec operator*(float s, vec a) {
    return {s * a.x, s * a.y, s * a.z};
}
float dot(vec a, vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
vec cross(vec a, vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
vec unit(vec a) {
    return (1 / std::sqrt(dot(a, a))) * a;
}
vec point(const ht::ray &r, float t) {
    return {r.org[0] + t * r.dir[0], r.org[1] + t * r.dir[1], r.org[2] + t * r.dir[2]};
}
ht::ray ray_from(vec org, float tmin, vec dir, float tmax) {
    return ht::ray{{org.x, org.y, org.z}, tmin, {dir.x, dir.y, dir.z}, tmax};
}

constexpr int width = 320, height = 240;
constexpr vec eye = {0, 2.6f, 4.2f}, lamp = {3, 6, 2};

struct scene {
    std::vector<vec> vertices;
    std::vector<std::uint32_t> triangles;

    void quad(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
        for (const std::size_t i : {a, b, c, a, c, d})
            triangles.push_back(static_cast<std::uint32_t>(i));
    }
};

scene torus_on_a_floor() {
    constexpr std::size_t around = 96, along = 48;
    constexpr float turn = 6.2831853f;
    scene s;
    for (std::size_t i = 0; i < around * along; ++i) {
        const float a = turn * static_cast<float>(i / along) / around;
        const float b = turn * static_cast<float>(i % along) / along;
        const float r = 1.2f + 0.45f * std::cos(b);
        s.vertices.push_back({r * std::cos(a), 0.45f * std::sin(b), r * std::sin(a)});
        const std::size_t here = i / along * along, next = (here + along) % (around * along);
        const std::size_t j = i % along, k = (j + 1) % along;
        s.quad(here + j, here + k, next + k, next + j);
    }
    const std::size_t f = s.vertices.size();
    for (const vec corner : {vec{-6, -0.45f, -6}, vec{-6, -0.45f, 6}, vec{6, -0.45f, 6}})
        s.vertices.push_back(corner);
    s.vertices.push_back({6, -0.45f, -6});
    s.quad(f, f + 1, f + 2, f + 3);
    return s;
}

std::vector<ht::ray> camera_rays() {
    const vec forward = unit(vec{0, -0.25f, 0} - eye), right = unit(cross(forward, {0, 1, 0}));
    const vec up = cross(right, forward);
    std::vector<ht::ray> rays;
    for (int i = 0; i < width * height; ++i) {
        const float x = 0.9f * (2.0f * static_cast<float>(i % width) / width - 1) / 2;
        const float y = 0.9f * (1 - 2.0f * static_cast<float>(i / width) / height) * 3 / 8;
        rays.push_back(ray_from(eye, 0, forward + x * right + y * up, INFINITY));
    }
    return rays;
}

vec normal_of(const scene &s, std::uint32_t triangle, vec towards) {
    const std::uint32_t *const i = &s.triangles[3 * triangle];
    const vec a = s.vertices[i[0]];
    const vec n = unit(cross(s.vertices[i[1]] - a, s.vertices[i[2]] - a));
    return dot(n, towards) < 0 ? n : -1 * n;
}

// A batch for what is seen, and a batch for what the lamp sees of it.
std::vector<unsigned char> render(const scene &s, const ht::tree &tree) {
    const std::vector<ht::ray> rays = camera_rays();
    std::vector<ht::hit> hits(rays.size());
    tree.intersect(rays.data(), rays.size(), hits.data());

    std::vector<ht::ray> to_lamp(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (hits[i].prim != HTREE_NONE)
            to_lamp[i] = ray_from(lamp, 0, point(rays[i], hits[i].t) - lamp, 0.999f);
    std::vector<std::uint8_t> dark(rays.size());
    tree.occluded(to_lamp.data(), to_lamp.size(), dark.data());

    std::vector<unsigned char> pixels;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        vec colour = {0.16f, 0.18f, 0.22f};
        if (hits[i].prim != HTREE_NONE) {
            const vec n = normal_of(s, hits[i].prim, point(rays[i], 1) - eye);
            const float lit = std::fmax(0.0f, dot(n, unit(lamp - point(rays[i], hits[i].t))));
            const float light = 0.25f + (dark[i] ? 0.0f : 0.75f * lit);
            colour = light * (0.5f * (n + vec{1, 1, 1}));
        }
        for (const float c : {colour.x, colour.y, colour.z})
            pixels.push_back(static_cast<unsigned char>(255 * std::fmin(1.0f, std::sqrt(c))));
    }
    return pixels;
}

} // namespace

int main(int count, char **arguments) try {
    if (count < 2) {
        std::fprintf(stderr, "usage: picture OUT.ppm [KIND]\n");
        return 2;
    }
    const ht::kind kind = count > 2 ? ht::kind_from_name(arguments[2]) : ht::kind::fast;
    const scene s = torus_on_a_floor();
    const ht::tree tree = ht::tree::build(ht::mesh(s.vertices.data(), s.vertices.size())
                                              .indices(s.triangles.data(), s.triangles.size() / 3),
                                          ht::options(kind));
    const std::vector<unsigned char> pixels = render(s, tree);
    std::ofstream out(arguments[1], std::ios::binary);
    out << "P6\n" << width << ' ' << height << "\n255\n";
    out.write(reinterpret_cast<const char *>(pixels.data()),
              static_cast<std::streamsize>(pixels.size()));
    out.close();
    if (!out) throw ht::error(ht::status::argument, "cannot write the picture");
    std::printf("%s: %zu triangles by kind %s\n", arguments[1], s.triangles.size() / 3,
                ht::kind_name(static_cast<ht::kind>(tree.stats().kind)));
} catch (const ht::error &why) {
    std::fprintf(stderr, "%s: %s\n", why.name(), why.what());
    return 1;
}
