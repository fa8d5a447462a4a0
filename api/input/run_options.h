// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/input/option_reader.h"
#include "api/run/deadline.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Returns the values of the option `quality`. The last value, `stealthy`, is available for points in the plane and in
/// space, but not for halftones and surfaces.
std::span<const Choice<Quality>> qualities();

inline constexpr std::uint64_t kMaxIterations = 1000, kMaxPasses = 100;

// Each of these functions reads the option after which it is named into the options of a run. Errors: Malformed.

template <class Run>
Result<void> read_seed(const Input& input, Run& run) {
    return assign(run.seed, read_integer(input, 0, kMaxInteger));
}
template <class Run>
Result<void> read_iterations(const Input& input, Run& run) {
    return assign(run.iterations, read_integer(input, 0, kMaxIterations));
}
template <class Run>
Result<void> read_passes(const Input& input, Run& run) {
    return assign(run.passes, read_integer(input, 1, kMaxPasses));
}
template <class Run>
Result<void> read_quality(const Input& input, Run& run) {
    return assign(run.quality, read_choice<Quality>(input, qualities()));
}
/// Reads the option `quality` without the value `stealthy`.
template <class Run>
Result<void> read_quality_without_stealthy(const Input& input, Run& run) {
    return assign(run.quality, read_choice<Quality>(input, qualities().first(qualities().size() - 1)));
}

/// Reads the option `on_deadline`.
Result<OnStop> read_on_deadline(const Input& input);

}  // namespace ccdt::api
