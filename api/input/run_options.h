// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/input/option_reader.h"
#include "api/run/deadline.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {

/// Returns the values of the option `quality`.
std::span<const Choice<Quality>> qualities();

/// Reads the option after which the function is named. Errors: Malformed.
Result<void> read_seed(const Input& input, Options& options);
Result<void> read_iterations(const Input& input, Options& options);
Result<void> read_passes(const Input& input, Options& options);
Result<void> read_quality(const Input& input, Options& options);
/// Reads the option `quality` of /halftone, which has no value `stealthy`.
Result<void> read_halftone_quality(const Input& input, Options& options);
/// Reads the option `on_deadline`.
Result<OnStop> read_on_deadline(const Input& input);

}  // namespace ccdt::api
