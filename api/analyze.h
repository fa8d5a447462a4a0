#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/domain_reader.h"
#include "api/input/file_formats.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "core/analysis/analysis.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

struct AnalyzeRequest;

/// Format of an analysis: a row of the table in analyze.cpp.
struct AnalysisFormat {
    FileFormat file;
    Estimate cost;  ///< of writing
    Result<std::string> (&write)(const AnalyzeRequest& request, const Analysis& analysis, const Domain& domain);
};

/// Formats of /analyze, in the server's order of preference.
std::span<const AnalysisFormat* const> analyze_formats();

/// Names of the members of a request.
std::vector<std::string_view> analyze_options();

/// Request to /analyze, with its options.
struct AnalyzeRequest {
    std::vector<std::vector<Point>> sets;
    bool single = false;  ///< came as `points`, not as `sets`
    Rectangle domain{1, 1, true};
    AnalysisOptions options;
    bool spectrum = false;                   ///< add it to the JSON
    const AnalysisFormat* format = nullptr;  ///< never null in a request that was parsed
};

/// Reads a request: a JSON object.
///
/// @param accept  the Accept header, empty if there is none; the member `format` wins over it
/// Errors: Malformed for what is not JSON, an unknown or repeated member, a value of the wrong kind or out of range,
/// not exactly one of points and sets; LimitExceeded for more points in all than limits.max_sites; NotAcceptable. The
/// field is a JSON Pointer.
Result<AnalyzeRequest> parse_analyze(std::string_view body, std::string_view accept, const Limits& limits);

/// Analyses, writes JSON or draws the plot.
///
/// @param control  a stop ends it soon, with nothing to show for it
/// @param timings  filled as far as it came
/// Errors: those of make_domain and analyse, the field a JSON Pointer. Same request, same bytes.
Result<Answer> run_analyze(const AnalyzeRequest& request, const Control& control, Timings& timings);

}  // namespace ccdt::api
