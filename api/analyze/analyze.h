// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/input/domain_reader.h"
#include "api/input/file_formats.h"
#include "api/input/polygon_reader.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/points/analysis/analysis.h"

namespace ccdt::api {

struct AnalyzeRequest;

/// Format of an analysis: a row of the table in analyze.cpp.
struct AnalysisFormat {
    FileFormat file;
    Estimate cost;  ///< cost of writing the answer
    Result<std::string> (&write)(const AnalyzeRequest& request, const Analysis& analysis);
};

/// Returns the formats of /analyze, in the server's order of preference.
std::span<const AnalysisFormat* const> analyze_formats();

/// Returns the names of the options.
std::vector<std::string_view> analyze_options();

/// Sets of points in the plane, with their domain.
struct PlaneSets {
    std::vector<std::vector<Point>> sets;
    Rectangle domain{1, 1, true};
    std::optional<PolygonInput> polygon;        ///< replaces the domain
    static constexpr double kMaxFrequency = 4;  ///< default of max_frequency
};
/// Sets of points in space, with their domain.
struct SpaceSets {
    std::vector<std::vector<Point3>> sets;
    BoxDomain3 domain{{1, 1, 1}, true};
    static constexpr double kMaxFrequency = 2;
};
using AnySets = std::variant<PlaneSets, SpaceSets>;

/// Request to /analyze, with its options.
struct AnalyzeRequest {
    AnySets points;
    bool single = false;  ///< whether the request gave `points` instead of `sets`
    AnalysisOptions options;
    bool spectrum = false;                   ///< whether to add the spectrum to the JSON
    const AnalysisFormat* format = nullptr;  ///< never null in a parsed request
};

/// Reads a request, which is a JSON object. Points with three coordinates are in space.
///
/// @param accept  the Accept header, empty if there is none; the member `format` takes precedence
/// Errors: Malformed for invalid JSON, for an unknown or repeated member, for a value of the wrong type or out of
/// range, and unless exactly one of `points` and `sets` is given; LimitExceeded for more than limits.max_sites points
/// in total; NotAcceptable if the client accepts none of the formats; those of make_domain(), of PolygonInput and, with
/// a domain, of check_analysis().
/// Error::field is a JSON Pointer.
Result<AnalyzeRequest> parse_analyze(std::string_view body, std::string_view accept, const Limits& limits);

/// Analyses the points, then writes JSON or draws the plot.
///
/// Polygons are repaired as by /sample. Errors: Unusable for a spectrum without rings, for polygons without area, and
/// for polygons that cover less than half of the sum of their areas, from which cost_of() estimates; Stopped; those of
/// analyse() and of drawing a plot. The same request gives the same bytes.
Result<Answer> run_analyze(const AnalyzeRequest& request, const Control& control, Timings& timings);

/// Estimates the cost of computing an answer, before the computation begins.
Cost cost_of(const AnalyzeRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const AnalyzeRequest& request);

}  // namespace ccdt::api
