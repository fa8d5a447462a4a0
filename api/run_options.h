#pragma once

#include "api/method.h"
#include "api/option_reader.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {

/// Options that every endpoint shares; their names are its members'.
Result<void> read_seed(const Input& input, Options& options);
Result<void> read_iterations(const Input& input, Options& options);
Result<void> read_passes(const Input& input, Options& options);
Result<void> read_quality(const Input& input, Options& options);

/// Distributes, and takes a run that was stopped for a failure.
Result<Distribution> distribute_all(const Domain& domain, const Density& density, const Options& options,
                                    const Control& control, Method method = Method::Ccdt);

/// Errors: Stopped if it was asked for.
Result<void> check_stop(const Control& control);

}  // namespace ccdt::api
