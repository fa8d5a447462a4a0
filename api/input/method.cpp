// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/method.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#ifdef CCDT_BASELINES
#include "core/baselines/ccvt.h"
#include "core/baselines/cvt.h"
#include "core/baselines/odt.h"
#include "core/baselines/random_sites.h"
#endif

namespace ccdt::api {
namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();  ///< no limit other than that of the server

constexpr MethodOptions kAll = {.iterations = true, .passes = true, .quality = true, .tolerance = true, .fixed = true};
/// Estimates the cost of computing, on a grid, the areas that belong to fixed points.
Estimate fixed_areas_cost(const Options& options) {
    if (options.fixed.empty()) return {};
    constexpr double kCellsOfEach = 16, kMaxCells = 4'194'304, kBytes = 40, kTime = 0.6 * kMicrosecond;
    const double cells =
        std::min(kCellsOfEach * static_cast<double>(options.sites + options.fixed.size()) + 4'096, kMaxCells);
    return {cells * kBytes, cells * kTime};
}

/// Estimates the cost of the triangulation, the passes and the polish.
Estimate ccdt_cost(const Options& options, bool is_uniform) {
    const auto sites = static_cast<double>(options.sites + options.fixed.size());
    const bool polished = options.quality != Quality::Draft && options.iterations > 0;
    const double pass = is_uniform ? 0.06 : 0.22;
    double microseconds = 1 + pass * options.iterations * options.passes;
    if (polished && options.quality == Quality::Standard) microseconds += is_uniform ? 2.6 : 7;
    if (polished && options.quality >= Quality::Best) microseconds += is_uniform ? 12.5 : 22;
    const bool silent = polished && options.quality == Quality::Stealthy;
    if (silent) microseconds += 5;
    // Upper bound: the grids of the polish are as fine as the largest density requires. For photographs, a third of
    // this memory suffices.
    const double polishing = is_uniform ? 40 : 560;
    const double bytes =
        (is_uniform ? 240 : 330) + (polished ? polishing : 0) + (silent ? 200 : 0) + (options.keep_mesh ? 150 : 0);
    return Estimate{sites * bytes, sites * microseconds * kMicrosecond} + fixed_areas_cost(options);
}

#ifdef CCDT_BASELINES
constexpr MethodOptions kIterative = {
    .iterations = true, .passes = false, .quality = false, .tolerance = true, .fixed = false};
constexpr MethodOptions kNone = {
    .iterations = false, .passes = false, .quality = false, .tolerance = false, .fixed = false};

/// @param bytes                      memory per site
/// @param microseconds_an_iteration  time per site
Estimate iteration_cost(const Options& options, double bytes, double microseconds_an_iteration) {
    const auto sites = static_cast<double>(options.sites);
    return {sites * bytes, sites * microseconds_an_iteration * options.iterations * kMicrosecond};
}

Estimate cvt_cost(const Options& options, bool) {
    return iteration_cost(options, 1600, 560.0 / kCvtIterations);
}

Estimate odt_cost(const Options& options, bool) {
    return iteration_cost(options, 400, 45.0 / kOdtIterations);
}

Estimate ccvt_cost(const Options& options, bool) {
    return iteration_cost(options, 9500, 850.0 / kCcvtIterations);
}

Estimate random_cost(const Options& options, bool) {
    return Estimate{290, 2.5 * kMicrosecond} * static_cast<double>(options.sites);
}

#endif

constexpr Method kMethods[] = {
    {"ccdt", "CCDT", kNoLimit, Options{}.iterations, kAll, ccdt_cost, distribute},
#ifdef CCDT_BASELINES
    {"cvt", "CVT, Lloyd's method", 50'000, kCvtIterations, kIterative, cvt_cost, cvt},
    {"odt", "ODT", 500'000, kOdtIterations, kIterative, odt_cost, odt},
    {"ccvt", "CCVT", 20'000, kCcvtIterations, kIterative, ccvt_cost, ccvt},
    {"random", "random", kNoLimit, 0, kNone, random_cost, random_sites},
#endif
};

constexpr std::array<Choice<bool MethodOptions::*>, 5> kOptions = {{{"iterations", &MethodOptions::iterations},
                                                                    {"passes", &MethodOptions::passes},
                                                                    {"quality", &MethodOptions::quality},
                                                                    {"tolerance", &MethodOptions::tolerance},
                                                                    {"fixed", &MethodOptions::fixed}}};

}  // namespace

std::span<const Method> methods() {
    return kMethods;
}

std::vector<std::string_view> option_names(const Method& method) {
    std::vector<std::string_view> names;
    for (const auto& [name, member] : kOptions) {
        if (method.options.*member) names.push_back(name);
    }
    return names;
}

Result<const Method*> read_method(const Input& input) {
    std::vector<Choice<const Method*>> choices;
    for (const Method& method : kMethods) choices.push_back({method.name, &method});
    return read_choice<const Method*>(input, choices);
}

Result<void> settle_method(const Method& method, const MethodOptions& given, Options& options) {
    for (const auto& [name, member] : kOptions) {
        if (!(given.*member) || method.options.*member) continue;
        return failure(ErrorCode::Malformed,
                       std::string(name) + " is not an option of method " + std::string(method.name),
                       pointer_below("", name));
    }
    if (options.sites > method.max_sites) {
        return failure(ErrorCode::LimitExceeded,
                       "sites is " + std::to_string(options.sites) + "; the limit of method " +
                           std::string(method.name) + " is " + std::to_string(method.max_sites),
                       "/sites");
    }
    if (!given.iterations) options.iterations = method.iterations;
    return {};
}

}  // namespace ccdt::api
