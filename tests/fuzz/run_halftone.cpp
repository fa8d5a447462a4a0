// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "api/halftone/halftone_cost.h"
#include "tests/fuzz/answer_checks.h"
#include "tests/fuzz/extreme_pictures.h"
#include "tests/fuzz/extremes.h"
#include "tests/support/halftone_requests.h"
#include "tests/support/shapes.h"

namespace ccdt::fuzz {
namespace {

using std::string_view_literals::operator""sv;

constexpr api::Limits kLimits = {.max_sites = 64, .max_pixels = 4'096};

/// The first bytes of a JPEG of 2 x 1 pixels. decode_of() makes the picture itself.
constexpr std::string_view kImage = "\xff\xd8\xff\xc0\0\x0b\x08\0\1\0\2\1"sv;

constexpr std::array<std::string_view, 3> kQualities = {"draft", "standard", "best"};
constexpr std::array<std::string_view, 3> kColours = {"gray", "cmyk", "rgb"};
constexpr std::array<std::string_view, 6> kPalettes = {
    "#000", "#fff", "#fff,#000", "#010101,#000", "#f00,#0f0,#00f,#0ff,#f0f,#ff0", "#00f,#ff8800,#123456"};
constexpr std::array<std::string_view, 4> kGrounds = {"transparent", "#000", "#fff", "#fefefe"};

constexpr std::array<std::string_view, 4> kLevels = {"0,1,0.1", "0,1,10", "0,5e-324", "0.9999999999999999,1,10"};

constexpr std::array<std::string_view, 3> kDetails = {"0", "1", "5e-324"};
constexpr std::array<std::string_view, 3> kDots = {"both", "ink", "paper"};

/// An option, and the function that takes its value from an input.
struct Option {
    std::string_view name;
    std::string (*take)(Bytes& input);
};

template <const auto& kWords>
std::string take_word(Bytes& input) {
    return std::string(take_one(kWords, input));
}

std::string take_text(Bytes& input) {
    return written(take_number(input));
}

template <unsigned kMax, unsigned kMin>
std::string take_count(Bytes& input) {
    return std::to_string(input.take<std::uint8_t>() % (kMax - kMin + 1) + kMin);
}

std::string take_true(Bytes&) {
    return "true";
}

constexpr std::array<Option, 21> kOptions = {{{"sites", take_count<24, 1>},
                                              {"iterations", take_count<6, 0>},
                                              {"passes", take_count<4, 1>},
                                              {"quality", take_word<kQualities>},
                                              {"scale", take_text},
                                              {"dot", take_text},
                                              {"antialias", take_true},
                                              {"invert", take_true},
                                              {"color", take_word<kColours>},
                                              {"palette", take_word<kPalettes>},
                                              {"foreground", [](Bytes&) { return std::string("#333"); }},
                                              {"background", take_word<kGrounds>},
                                              {"width_mm", take_text},
                                              {"style", [](Bytes&) { return std::string("stroke"); }},
                                              {"tone", [](Bytes&) { return std::string("perceptual"); }},
                                              {"on_deadline", [](Bytes&) { return std::string("partial"); }},
                                              {"levels", take_word<kLevels>},
                                              {"detail", take_word<kDetails>},
                                              {"dots", take_word<kDots>},
                                              {"paper", [](Bytes&) { return std::string("a4"); }},
                                              {"marks", take_true}}};

/// Takes options. Each bit of the first number tells whether an option is given.
std::vector<api::TextOption> take_options(Bytes& input) {
    const auto bits = input.take<std::uint32_t>();
    std::vector<api::TextOption> options{{"format", std::string(take_one(api::halftone_formats(), input)->file.name)},
                                         {"seed", take_count<3, 0>(input)}};
    for (std::size_t i = 0; i < kOptions.size(); ++i) {
        if ((bits >> i & 1) != 0) options.push_back({std::string(kOptions[i].name), kOptions[i].take(input)});
    }
    return options;
}

void check_points(const std::vector<Point>& points, const api::HalftoneRequest& request, const api::Answer& answer) {
    CCDT_CHECK(points.size() == answer.sites);
    // A picture of bare paper and solid ink needs no dots.
    const bool has_none = request.dots == api::Dots::Both && points.empty();
    CCDT_CHECK(has_none || !request.sites || points.size() == *request.sites);
    CCDT_CHECK(has_none || !points.empty());
    CCDT_CHECK(points.size() <= kLimits.max_sites);
    for (const Point& p : points) CCDT_CHECK(p.x > 0 && p.x < 64 && p.y > 0 && p.y < 64);
    // Dots of different inks may coincide.
    if (request.palette.inks.size() == 1) CCDT_CHECK(test::count_distinct(points) == points.size());
}

void check_answer(const api::HalftoneRequest& request, const api::Answer& answer) {
    CCDT_CHECK(!answer.partial && !answer.media_type.empty() && !answer.body.empty() && answer.pixels > 0);
    const std::string_view format = request.format->file.name;
    if (format == "png") return check_signature(answer.body, "\x89PNG\r\n");
    if (format == "webp") return check_signature(answer.body, "RIFF");
    if (format == "jpeg") return check_signature(answer.body, "\xff\xd8");
    if (format == "tiff") return check_signature(answer.body, "II");
    if (format == "svg") return check_svg(answer.body);
    if (format == "json") return check_points(points_of_json(answer.body), request, answer);
    if (format == "csv") return check_points(points_of_csv(answer.body), request, answer);
    const bool is_named = request.palette.mixing != api::Mixing::Cover && request.dots != api::Dots::Both;
    const std::size_t columns = is_named ? 3 : 2;
    if (format == "npy") return check_points(points_of_npy(answer.body, columns), request, answer);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses, estimates and answers a request to /halftone whose numbers are at the ends of their ranges.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    fuzz::Bytes input(fuzz::text_of(data, size));
    const auto options = fuzz::take_options(input);
    const auto request = api::parse_halftone(std::string(fuzz::kImage), options, {}, fuzz::kLimits);
    if (!request) {
        fuzz::check_error(request.error(), options);
        return 0;
    }
    fuzz::check_cost(api::cost_of(*request, fuzz::kLimits));
    const auto decode = fuzz::decode_of(input);
    const auto run = [&] {
        api::Timings timings;
        return api::run_halftone(*request, fuzz::kLimits, decode, {}, timings);
    };
    const auto answer = run();
    if (!answer) {
        fuzz::check_error(answer.error());
        return 0;
    }
    fuzz::check_answer(*request, *answer);
    CCDT_CHECK(fuzz::without_time(answer->body) == fuzz::without_time(run()->body));
    return 0;
}
