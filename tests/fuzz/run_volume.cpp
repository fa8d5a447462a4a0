// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/json/json_document.h"
#include "api/sample/spatial/volume_sample.h"
#include "tests/fuzz/extremes.h"
#include "tests/fuzz/sample3_checks.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 100, .max_pixels = 4'096};

constexpr std::array<std::string_view, 4> kQualities = {"draft", "standard", "best", "stealthy"};

/// Optional properties of a request, as bits of a number.
enum class Given : std::uint16_t {
    Torus = 1,
    Stretched = 2,
    Density = 4,
    Fixed = 8,
    Mesh = 16,
    Progressive = 32,
    Partial = 64,
    File = 128,
};

std::string list_of(Bytes& input, std::size_t count) {
    std::string list;
    for (std::size_t i = 0; i < count; ++i) list += (i > 0 ? "," : "") + written(take_number(input));
    return '[' + list + ']';
}

std::string take_density(Bytes& input) {
    const std::size_t width = input.take<std::uint8_t>() % 3 + 1, height = input.take<std::uint8_t>() % 3 + 1;
    return R"({"width":)" + std::to_string(width) + R"(,"height":)" + std::to_string(height) +
           R"(,"depth":2,"values":)" + list_of(input, 2 * width * height) + '}';
}

/// Takes the JSON of a request that is likely to be valid.
std::string take_request(Bytes& input, std::uint16_t bits) {
    const std::string x = written(take_number(input));
    const std::string y = is_given(bits, Given::Stretched) ? written(take_number(input)) : x;
    const std::string z = is_given(bits, Given::Stretched) ? written(take_number(input)) : x;
    std::string body = R"({"domain":{"type":")" + std::string(is_given(bits, Given::Torus) ? "torus" : "box") +
                       R"(","width":)" + x + R"(,"height":)" + y + R"(,"depth":)" + z + '}';
    body += R"(,"sites":)" + std::to_string(input.take<std::uint8_t>() % 24 + 1);
    body += R"(,"seed":)" + std::to_string(input.take<std::uint8_t>());
    body += R"(,"quality":")" + std::string(take_one(kQualities, input)) + '"';
    body += R"(,"format":")" + std::string(take_one(api::volume_formats(), input)->file.name) + '"';
    if (is_given(bits, Given::Density)) body += R"(,"density":)" + take_density(input);
    if (is_given(bits, Given::Fixed)) body += R"(,"fixed":[)" + list_of(input, 3) + ']';
    if (is_given(bits, Given::Mesh)) body += R"(,"mesh":true)";
    if (is_given(bits, Given::Progressive)) body += R"(,"order":"progressive")";
    if (is_given(bits, Given::Partial)) body += R"(,"on_deadline":"partial")";
    return body + '}';
}

/// @param file  header of an NPY file, and its data
Result<api::VolumeRequest> parse_file(std::string_view file) {
    if (!api::is_voxel_file(file)) return failure(ErrorCode::Malformed, "not a file of voxels");
    return api::parse_volume(api::open_voxels(file, kLimits), {{"sites", "9"}, {"domain", "torus"}}, "", kLimits);
}

Result<api::VolumeRequest> parse_json(std::string_view body) {
    return api::JsonDocument::parse(body).and_then([](const api::JsonDocument& document) {
        CCDT_CHECK(api::asks_for_volume(document.root()));
        return api::parse_volume(document.root(), {}, "", kLimits);
    });
}

void check_points(const api::VolumeRequest& request, const std::string& body) {
    const auto json = check_json(request, body, "tetrahedra");
    const Point3 sides = request.domain.sides;
    for (const auto& point : json.at("points")) {
        const auto is_inside = [](double v, double side) { return v >= 0 && v <= side; };
        CCDT_CHECK(is_inside(point.at(0), sides.x) && is_inside(point.at(1), sides.y) &&
                   is_inside(point.at(2), sides.z));
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses, estimates and answers a request for points in space. Its numbers are often at the ends of their ranges.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const std::string_view text = fuzz::text_of(data, size);
    fuzz::Bytes input(text);
    const auto bits = input.take<std::uint16_t>();
    const bool is_file = fuzz::is_given(bits, fuzz::Given::File);
    const std::string body =
        is_file ? std::string(text.substr(std::min(sizeof bits, size))) : fuzz::take_request(input, bits);
    fuzz::check_request(is_file ? fuzz::parse_file(body) : fuzz::parse_json(body), api::decode_inline(),
                        fuzz::check_points);
    return 0;
}
