#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "api/input/option_reader.h"
#include "api/method.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {

/// Options that every endpoint shares; their names are its members'.
Result<void> read_seed(const Input& input, Options& options);
Result<void> read_iterations(const Input& input, Options& options);
Result<void> read_passes(const Input& input, Options& options);
Result<void> read_quality(const Input& input, Options& options);

/// What a run that is stopped, by a deadline, comes to.
enum class OnStop { Error, Partial };
Result<void> read_on_deadline(const Input& input, OnStop& on_stop);

/// Distributes, and takes a run that was stopped for a failure unless its part will do.
Result<Distribution> distribute_all(const Domain& domain, const Density& density, const Options& options,
                                    const Control& control, OnStop on_stop, Method method = Method::Ccdt);

/// The same for each of several inks.
/// @param densities  [inks]
/// @param sites      [inks]; 0: nothing is distributed
Result<std::vector<Distribution>> distribute_all_inks(const Domain& domain, std::span<const Density> densities,
                                                      std::span<const std::size_t> sites, const Options& options,
                                                      const Control& control, OnStop on_stop);

/// What writing an answer listens to: nothing, where a part will do and is to be told in full.
std::stop_token stop_of_writing(const Control& control, OnStop on_stop);

/// Errors: Stopped if it was asked for.
Result<void> check_stop(const std::stop_token& stop);

}  // namespace ccdt::api
