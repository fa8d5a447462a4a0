// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "api/sample/mask/threshold_mask.h"
#include "api/sample/plane/sample.h"
#include "api/sample/plane/sample_cost.h"
#include "api/sample/plane/sample_parser.h"
#include "tests/fuzz/answer_checks.h"
#include "tests/fuzz/extreme_pictures.h"
#include "tests/fuzz/extremes.h"
#include "tests/fuzz/shape_checks.h"
#include "tests/support/shapes.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 100, .max_pixels = 4'096};

constexpr std::array<std::string_view, 4> kQualities = {"draft", "standard", "best", "stealthy"};

constexpr std::array<std::string_view, 3> kOrders = {"none", "path", "progressive"};

/// Optional members of a request, as bits of a number.
enum class Given : std::uint16_t {
    Iterations = 1,
    Passes = 2,
    Quality = 4,
    Tolerance = 8,
    Mesh = 16,
    WidthMm = 32,
    Stroke = 64,
    Width = 128,
    Dot = 256,
    Partial = 512,
    Reject = 1024,
    Avoid = 2048,
    Buffer = 4096,
    Fixed = 8192,
    Order = 16384,
    LonLat = 32768,
};

/// Builds a JSON object, member by member.
class Members {
public:
    void add(std::string_view name, std::string_view value) {
        text_.append(text_.size() > 1 ? ",\"" : "\"").append(name).append("\":").append(value);
    }
    void add(std::string_view name, double value) { add(name, std::string_view(written(value))); }
    void add_word(std::string_view name, std::string_view word) { add(name, '"' + std::string(word) + '"'); }
    std::string finish() { return text_ + '}'; }

private:
    std::string text_ = "{";
};

std::string coordinates(const Ring& ring) {
    std::string text = "[";
    for (const Point& p : ring) {
        text.append(text.size() > 1 ? "," : "");
        text.append("[" + written(p.x) + ',' + written(p.y) + ']');
    }
    return text + ']';
}

/// Takes a simple shape of any width, height and offset. One corner may be anywhere.
Ring take_ring(Bytes& input) {
    static const std::array<Ring, 5> kShapes = {{{{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                                                 {{0, 0}, {1, 0}, {0, 1}},
                                                 {{0, 0.5}, {0.5, 0}, {1, 0.5}, {0.5, 1}},
                                                 {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
                                                 {{0, 0}, {1, 0}, {1, 1}, {0.5, 0x1p-30}, {0, 1}}}};
    const auto bits = input.take<std::uint8_t>();
    Ring ring = kShapes[bits % kShapes.size()];
    const double width = take_number(input), height = (bits & 128) != 0 ? take_number(input) : width;
    const Point offset = (bits & 64) != 0 ? Point{take_number(input), -take_number(input)} : Point{};
    for (Point& p : ring) {
        p = {width * p.x + offset.x, height * p.y + offset.y};
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) p = {};
    }
    if ((bits & 32) != 0) {
        Point& anywhere = ring[input.take<std::uint8_t>() % ring.size()];
        anywhere = {take_number(input), take_number(input)};
    }
    return ring;
}

/// Takes a simple shape in degrees, anywhere on the globe and up to 360 degrees wide. One corner may be anywhere.
Ring take_ring_on_globe(Bytes& input) {
    constexpr double kTurn = 360, kSteps = 255;
    const auto degrees = [&](double from, double to) {
        return from + (to - from) * input.take<std::uint8_t>() / kSteps;
    };
    Ring ring = take_ring(input);
    const auto bits = input.take<std::uint8_t>();
    if ((bits & 1) != 0) return ring;
    Box box;
    for (const Point& p : ring) box.include(p);
    const Point from{degrees(-kTurn / 2, kTurn / 2), degrees(-90, 90)};
    const Point size{degrees(0, kTurn), degrees(0, 90 - from.y)};
    const double finer = (bits & 2) != 0 ? take_number(input) : 1;
    const auto scaled = [finer](double value, double least, double extent, double wanted) {
        return extent > 0 && std::isfinite(extent) ? (value - least) / extent * wanted * std::min(finer, 1.0) : 0;
    };
    for (Point& p : ring)
        p = from + Point{scaled(p.x, box.min.x, box.width(), size.x), scaled(p.y, box.min.y, box.height(), size.y)};
    return ring;
}

/// Takes a distance in metres, from ten micrometres to a million metres.
double take_metres(Bytes& input) {
    constexpr double kMin = -5, kMax = 6, kSteps = 255;
    return std::pow(10, kMin + (kMax - kMin) * input.take<std::uint8_t>() / kSteps);
}

void take_region(Bytes& input, Members& members) {
    members.add_word("coordinates", "lonlat");
    members.add("polygon", coordinates(take_ring_on_globe(input)));
    if (input.take<std::uint8_t>() % 4 == 0) members.add("holes", '[' + coordinates(take_ring_on_globe(input)) + ']');
}

void take_domain(Bytes& input, Members& members) {
    const auto kind = input.take<std::uint8_t>() % 8;
    if (kind < 4) {
        const double width = take_number(input), height = kind < 2 ? width : take_number(input);
        const std::string_view type = kind % 2 == 0 ? "rectangle" : "torus";
        members.add("domain", R"({"type":")" + std::string(type) + R"(","width":)" + written(width) + R"(,"height":)" +
                                  written(height) + '}');
        return;
    }
    members.add("polygon", coordinates(take_ring(input)));
    if (kind == 7) members.add("holes", '[' + coordinates(take_ring(input)) + ']');
}

void take_density(Bytes& input, Members& members) {
    // Only the header of this file is read; decode_of() makes the picture.
    constexpr std::string_view kImage = R"({"image":"/9j/wAALCAABAAIB"})";
    const auto shape = input.take<std::uint8_t>();
    if (shape < 32) return;
    if (shape < 64) return members.add("density", kImage);
    const int width = shape % 8 + 1, height = shape / 8 % 4 + 1;
    std::string values;
    for (int i = 0; i < width * height; ++i) values += (i > 0 ? "," : "") + written(take_number(input));
    members.add("density", R"({"width":)" + std::to_string(width) + R"(,"height":)" + std::to_string(height) +
                               R"(,"values":[)" + values + "]}");
}

/// Takes a request that is likely to be valid.
std::string take_request(Bytes& input) {
    Members members;
    const auto bits = input.take<std::uint16_t>();
    const auto given = [bits](Given member) { return (bits & static_cast<std::uint16_t>(member)) != 0; };
    const auto method = input.take<std::uint8_t>() % (2 * api::methods().size());
    if (method < api::methods().size()) members.add_word("method", api::methods()[method].name);
    members.add("sites", input.take<std::uint8_t>() % 16 + 1);
    members.add("seed", input.take<std::uint8_t>());
    members.add_word("format", take_one(api::sample_formats(), input)->file.name);
    // The default numbers of iterations of the other methods would take long, and test no more than a few iterations.
    if (given(Given::Iterations) || method < 4) members.add("iterations", input.take<std::uint8_t>() % 8);
    if (given(Given::Passes)) members.add("passes", input.take<std::uint8_t>() % 4 + 1);
    if (given(Given::Quality)) members.add_word("quality", take_one(kQualities, input));
    if (given(Given::Tolerance)) members.add("tolerance", take_number(input));
    if (given(Given::Mesh)) members.add("mesh", "true");
    if (given(Given::WidthMm)) members.add("width_mm", take_number(input));
    if (given(Given::Stroke)) members.add_word("style", "stroke");
    if (given(Given::Width)) members.add("width", std::floor(take_number(input)));
    if (given(Given::Dot)) members.add("dot", take_number(input));
    if (given(Given::Partial)) members.add_word("on_deadline", "partial");
    if (given(Given::Reject)) members.add_word("invalid", "reject");
    const bool on_globe = given(Given::LonLat);
    on_globe ? take_region(input, members) : take_domain(input, members);
    take_density(input, members);
    if (given(Given::Fixed)) members.add("fixed", coordinates(take_ring(input)));
    if (given(Given::Buffer)) members.add("buffer", on_globe ? take_metres(input) : take_number(input));
    if (given(Given::Order)) members.add_word("order", take_one(kOrders, input));
    if (given(Given::Avoid))
        members.add("avoid", '[' + coordinates(take_ring(input)) + ',' + coordinates(take_ring(input)) + ']');
    return members.finish();
}

/// Checks that points in degrees are on the globe and distinct.
void check_points_on_globe(const std::vector<Point>& points, std::size_t sites) {
    constexpr double kFarthest = 540;
    CCDT_CHECK(points.size() == sites);
    for (const Point& p : points) CCDT_CHECK(std::abs(p.x) <= kFarthest && std::abs(p.y) <= 90);
    CCDT_CHECK(test::count_distinct(points) == points.size());
}

/// The domain of a request, against which its points are checked.
struct Made {
    Domain domain;
    std::vector<PolygonPart> parts;  ///< the polygons of the request; empty for a rectangle, torus or repaired domain
};

Made make(const api::SampleRequest& request) {
    if (const auto* rectangle = std::get_if<api::Rectangle>(&request.region.domain))
        return {api::make_domain(*rectangle).value(), {}};
    const auto& parts = std::get<api::PolygonInput>(request.region.domain).parts;
    auto repaired = Domain::repair(parts).value();
    return {std::move(repaired.domain), repaired.repairs.empty() ? parts : std::vector<PolygonPart>()};
}

/// Checks that no point lies in excluded areas or in the buffer along the border. Repaired polygons are skipped,
/// because their crossings are rounded.
void check_exclusions(const api::SampleRequest& request, const Made& made, const std::vector<Point>& points) {
    const auto& avoid = request.region.avoid.parts;
    const double rounding =
        made.domain.resolution() * std::max(made.domain.bounds().width(), made.domain.bounds().height());
    for (const Point& p : points) {
        if (made.parts.empty() || request.region.buffer == 0) break;
        CCDT_CHECK(test::distance_to_border(made.parts, p) >= request.region.buffer - rounding);
    }
    if (avoid.empty() || !Domain::repair_area(avoid)->repairs.empty()) return;
    CCDT_CHECK(test::count_outside(avoid, points) == points.size());
}

void check_answer(const api::SampleRequest& request, const api::Answer& answer) {
    CCDT_CHECK(answer.sites == request.run.sites && !answer.partial && !answer.media_type.empty() &&
               !answer.body.empty());
    const auto check = [&](const std::vector<Point>& points) {
        if (request.region.coordinates == api::Coordinates::LonLat)
            return check_points_on_globe(points, request.run.sites);
        const auto made = make(request);
        check_points(points, request.run.sites, made.domain, made.parts);
        check_exclusions(request, made, points);
    };
    const std::string_view format = request.output.format->file.name;
    if (format == "svg") return check_svg(answer.body);
    if (format == "jpeg") return check_signature(answer.body, "\xff\xd8");
    if (format == "png") return check_signature(answer.body, "\x89PNG\r\n");
    if (format == "json") return check(points_of_json(answer.body));
    if (format == "geojson") return check(points_of_feature(answer.body));
    if (format == "ndjson" || format == "geojsonseq") return check(points_of_lines(answer.body));
    if (format == "csv") return check(points_of_csv(answer.body));
    if (format == "npy")
        return check(points_of_npy(answer.body, request.output.order == api::PointOrder::Progressive ? 3 : 2));
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses, estimates and answers a request to /sample whose numbers are at the ends of their ranges.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    fuzz::Bytes input(fuzz::text_of(data, size));
    const auto body = fuzz::take_request(input);
    const auto request = api::parse_sample(body, {}, {}, fuzz::kLimits);
    if (!request) {
        fuzz::check_error(request.error(), body);
        return 0;
    }
    fuzz::check_cost(api::cost_of(*request, fuzz::kLimits));
    const auto decode = fuzz::decode_of(input);
    const auto run = [&] {
        api::Timings timings;
        if (request->threshold_mask) return api::run_mask(*request->threshold_mask, {}, timings);
        return api::run_sample(*request, fuzz::kLimits, decode, {}, timings);
    };
    const auto answer = run();
    if (!answer) {
        fuzz::check_error(answer.error(), body);
        return 0;
    }
    fuzz::check_answer(*request, *answer);
    CCDT_CHECK(fuzz::without_time(answer->body) == fuzz::without_time(run()->body));
    return 0;
}
