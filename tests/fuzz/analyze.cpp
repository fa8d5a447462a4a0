// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/analyze.h"

#include <algorithm>
#include <cmath>

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 1'000, .max_pixels = 4'096};
constexpr double kMaxWork = 256;  ///< maximum of points * max_frequency^dimensions for which a request is computed

/// Numbers of points of a request.
struct Count {
    std::size_t largest = 0;  ///< points of the largest set
    std::size_t all = 0;      ///< points of all sets
};

Count count_points(const api::AnalyzeRequest& request) {
    Count count;
    std::visit(
        [&](const auto& given) {
            for (const auto& set : given.sets) {
                count.largest = std::max(count.largest, set.size());
                count.all += set.size();
            }
        },
        request.points);
    return count;
}

/// Whether "nan" or "inf" occurs in place of a number. Pictures in base64 may contain these letters, too.
bool holds_no_number(std::string_view svg) {
    constexpr std::string_view kBefore = "\" ,-";
    for (const std::string_view word : {"nan", "inf"}) {
        for (auto at = svg.find(word); at != std::string_view::npos; at = svg.find(word, at + 1)) {
            if (at > 0 && kBefore.find(svg[at - 1]) != std::string_view::npos) return true;
        }
    }
    return false;
}

/// Checks that no number is null, which stands for NaN and infinity. Only low_frequency_power may be null.
void check_nulls(std::string_view json) {
    constexpr std::string_view kUnknown = "\"low_frequency_power\":null";
    const auto null = json.find("null"), unknown = json.find(kUnknown);
    if (null == std::string_view::npos) return;
    CCDT_CHECK(null == unknown + kUnknown.size() - 4);
    CCDT_CHECK(json.find("null", null + 1) == std::string_view::npos);
}

void run(api::AnalyzeRequest request, const api::AnalysisFormat& format, std::string_view body) {
    request.format = &format;
    api::Timings timings;
    const auto answer = api::run_analyze(request, {}, timings);
    if (!answer) return check_error(answer.error(), body);
    const bool is_json = format.file.name == "json";
    CCDT_CHECK(answer->media_type == format.file.content_type());
    if (is_json) {
        check_json(answer->body);
        check_nulls(answer->body);
    } else {
        CCDT_CHECK(answer->body.starts_with("<"));
        CCDT_CHECK(!holds_no_number(answer->body));
    }
}

void check_request(const api::AnalyzeRequest& request, std::string_view body) {
    const double frequency = request.options.max_frequency;
    CCDT_CHECK(frequency >= 1 && frequency <= 16);
    const auto* const flat = std::get_if<api::PlaneSets>(&request.points);
    const auto* const space = std::get_if<api::SpaceSets>(&request.points);
    CCDT_CHECK(!flat || (flat->domain.width > 0 && flat->domain.height > 0));
    CCDT_CHECK(!space || std::min({space->domain.sides.x, space->domain.sides.y, space->domain.sides.z}) > 0);
    CCDT_CHECK(!request.single || (flat ? flat->sets.size() : space->sets.size()) == 1);
    const Count points = count_points(request);
    CCDT_CHECK(points.all <= kLimits.max_sites);
    if (static_cast<double>(points.largest) * std::pow(frequency, space ? 3 : 2) > kMaxWork) return;
    for (const api::AnalysisFormat* format : api::analyze_formats()) {
        if (format->file.name != "png") run(request, *format, body);
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as the body of a request to /analyze, and computes the answer to small requests.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto body = fuzz::text_of(data, size);
    const auto request = api::parse_analyze(body, {}, fuzz::kLimits);
    if (request) {
        fuzz::check_request(*request, body);
    } else {
        fuzz::check_error(request.error(), body);
    }
    return 0;
}
