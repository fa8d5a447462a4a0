// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/sample/spatial/surface_sample.h"
#include "api/sample/spatial/volume_sample.h"
#include "tests/fuzz/extremes.h"
#include "tests/fuzz/sample3_checks.h"
#include "tests/support/surfaces.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 100};

constexpr std::array<std::string_view, 3> kQualities = {"draft", "standard", "best"};

/// Optional properties of a request, as bits of a number.
enum class Given : std::uint16_t {
    Iterations = 1,
    Passes = 2,
    Quality = 4,
    Mesh = 8,
    Partial = 16,
    Crease = 32,
    Fixed = 64,
    Progressive = 128,
    Colours = 256,
    Texture = 512,
    Stretched = 1024,
    Moved = 2048,
    Damaged = 4096,
    Solid = 8192,
    Picture = 16384,
};

TriangleSoup take_shape(Bytes& input) {
    switch (input.take<std::uint8_t>() % 6) {
        case 0:
            return test::square_surface(3);
        case 1:
            return test::sphere_surface(1);
        case 2:
            return test::torus_surface(1, 0.25, 8, 4);
        case 3:
            return test::moebius_strip(8, 1);
        case 4:
            return test::joined(test::cube_surface(), test::cube_surface({1, 1, 0}));
        default:
            return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    }
}

/// Takes triangles of any size, at any distance from the origin, some of which may be damaged.
TriangleSoup take_soup(Bytes& input, std::uint16_t bits) {
    TriangleSoup soup = take_shape(input);
    const double x = take_number(input);
    const Point3 scale =
        is_given(bits, Given::Stretched) ? Point3{x, take_number(input), take_number(input)} : Point3{x, x, x};
    const Point3 offset = is_given(bits, Given::Moved) ? Point3{take_number(input), -take_number(input), 1} : Point3{};
    for (Point3& p : soup.vertices) p = {scale.x * p.x + offset.x, scale.y * p.y + offset.y, scale.z * p.z + offset.z};
    if (is_given(bits, Given::Damaged)) {
        soup.vertices[input.take<std::uint8_t>() % soup.vertices.size()].z = input.take<double>();
        auto& triangle = soup.triangles[input.take<std::uint8_t>() % soup.triangles.size()];
        triangle[1] = static_cast<std::uint32_t>(input.take<std::uint8_t>() % soup.vertices.size());
    }
    for (std::size_t i = 0; i < soup.vertices.size(); ++i) {
        if (is_given(bits, Given::Colours)) soup.colours.push_back({input.take<float>(), 0.5F, 1});
        if (is_given(bits, Given::Texture)) soup.texture.push_back({input.take<float>(), 0});
    }
    if (is_given(bits, Given::Picture)) {
        constexpr std::uint8_t kTexels[] = {0, 255, 128, 64, 255, 0};
        Material material{.width = 3, .height = 2};
        for (const std::uint8_t grey : kTexels) soup.texels.push_back({grey, grey, grey, input.take<std::uint8_t>()});
        for (Wrap& wrap : material.wrap) wrap = static_cast<Wrap>(input.take<std::uint8_t>() % 3);
        material.alpha = static_cast<AlphaMode>(input.take<std::uint8_t>() % 3);
        for (float& value : material.transform) value = input.take<float>();
        soup.materials = {material};
        soup.material_of.assign(soup.triangles.size(), 0);
    }
    return soup;
}

std::string take_density(Bytes& input, const TriangleSoup& soup) {
    constexpr std::array<std::string_view, 3> kWords = {"uniform", "color", "curvature"};
    const auto kind = input.take<std::uint8_t>() % 8;
    if (kind < 5) return std::string(kWords[static_cast<std::size_t>(kind) % kWords.size()]);
    std::string list = "[";
    for (std::size_t i = 0; i < soup.vertices.size(); ++i) list += (i > 0 ? "," : "") + written(take_number(input));
    return list + ']';
}

/// Takes options of points inside a mesh that are likely to be valid.
std::vector<api::TextOption> take_solid_options(Bytes& input, std::uint16_t bits) {
    std::vector<api::TextOption> options = {{"domain", "solid"},
                                            {"sites", std::to_string(input.take<std::uint8_t>() % 24 + 1)},
                                            {"seed", std::to_string(input.take<std::uint8_t>())},
                                            {"format", std::string(take_one(api::volume_formats(), input)->file.name)}};
    if (is_given(bits, Given::Quality)) options.push_back({"quality", std::string(take_one(kQualities, input))});
    if (is_given(bits, Given::Mesh)) options.push_back({"mesh", "true"});
    if (is_given(bits, Given::Crease)) options.push_back({"crease", written(take_number(input))});
    if (is_given(bits, Given::Progressive)) options.push_back({"order", "progressive"});
    if (is_given(bits, Given::Colours))
        options.push_back({"density", R"({"width":2,"height":1,"depth":1,"values":[)" + written(take_number(input)) +
                                          "," + written(take_number(input)) + "]}"});
    if (is_given(bits, Given::Fixed))
        options.push_back({"fixed", "[[" + written(take_number(input)) + "," + written(take_number(input)) + ",0]]"});
    return options;
}

/// Takes options of points on a surface that are likely to be valid.
std::vector<api::TextOption> take_options(Bytes& input, std::uint16_t bits, const TriangleSoup& soup) {
    std::vector<api::TextOption> options = {{"sites", std::to_string(input.take<std::uint8_t>() % 24 + 1)},
                                            {"seed", std::to_string(input.take<std::uint8_t>())},
                                            {"format", std::string(take_one(api::surface_formats(), input)->file.name)},
                                            {"density", take_density(input, soup)}};
    if (is_given(bits, Given::Iterations))
        options.push_back({"iterations", std::to_string(input.take<std::uint8_t>() % 8)});
    if (is_given(bits, Given::Passes))
        options.push_back({"passes", std::to_string(input.take<std::uint8_t>() % 4 + 1)});
    if (is_given(bits, Given::Quality)) options.push_back({"quality", std::string(take_one(kQualities, input))});
    if (is_given(bits, Given::Mesh)) options.push_back({"mesh", "true"});
    if (is_given(bits, Given::Partial)) options.push_back({"on_deadline", "partial"});
    if (is_given(bits, Given::Crease)) options.push_back({"crease", written(take_number(input))});
    if (is_given(bits, Given::Progressive)) options.push_back({"order", "progressive"});
    if (is_given(bits, Given::Fixed))
        options.push_back({"fixed", "[[" + written(take_number(input)) + "," + written(take_number(input)) + ",0]]"});
    return options;
}

void check_points(const api::VolumeRequest& request, const TriangleSoup& soup, const std::string& body) {
    const auto json = check_json(request, body, "tetrahedra");
    const Box3 box = bounds_of(soup.vertices);
    const Point3 margin = 1e-6 * (box.max - box.min);
    for (const auto& point : json.at("points")) {
        const Point3 p{point.at(0), point.at(1), point.at(2)};
        CCDT_CHECK(p.x >= box.min.x - margin.x && p.y >= box.min.y - margin.y && p.z >= box.min.z - margin.z);
        CCDT_CHECK(p.x <= box.max.x + margin.x && p.y <= box.max.y + margin.y && p.z <= box.max.z + margin.z);
    }
}

void check_points(const api::SurfaceRequest& request, const TriangleSoup& soup, const std::string& body) {
    const auto json = check_json(request, body, "triangles");
    const std::size_t sites = request.run.sites;
    for (const auto* list : {"faces", "barycentric", "normals"}) CCDT_CHECK(json.at(list).size() == sites);
    for (const auto& face : json.at("faces")) CCDT_CHECK(face.get<std::size_t>() < soup.triangles.size());
    for (const auto& weights : json.at("barycentric")) {
        double sum = 0;
        for (const auto& weight : weights) {
            CCDT_CHECK(weight.get<double>() >= 0);
            sum += weight.get<double>();
        }
        CCDT_CHECK(std::abs(sum - 1) < 1e-9);
    }
    for (const auto& normal : json.at("normals")) {
        const Point3 n{normal.at(0), normal.at(1), normal.at(2)};
        CCDT_CHECK(std::abs(length(n) - 1) < 1e-6);
    }
    CCDT_CHECK(json.at("variation").get<double>() >= 0);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses, estimates and answers a request for points on a surface or inside it. Its numbers are often at the ends of
/// their ranges.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    fuzz::Bytes input(fuzz::text_of(data, size));
    const auto bits = input.take<std::uint16_t>();
    const TriangleSoup soup = fuzz::take_soup(input, bits);
    api::SurfaceFile file;
    file.header.max_triangles = soup.triangles.size();
    file.header.max_vertices = soup.vertices.size();
    file.header.texels = soup.texels.size();
    api::Decode decode;
    decode.surface = [&](std::string_view, const api::SurfaceHeader&, const std::stop_token&) {
        return Result<api::SurfaceContents>(api::SurfaceContents{soup});
    };
    const auto check_points = [&](const auto& request, const std::string& body) {
        fuzz::check_points(request, soup, body);
    };
    if (fuzz::is_given(bits, fuzz::Given::Solid)) {
        fuzz::check_request(api::parse_solid(file, fuzz::take_solid_options(input, bits), "", fuzz::kLimits), decode,
                            check_points);
    } else {
        fuzz::check_request(api::parse_surface(file, fuzz::take_options(input, bits, soup), "", fuzz::kLimits), decode,
                            check_points);
    }
    return 0;
}
