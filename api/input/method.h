// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "api/run/estimate.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// A subset of the options that only some methods support. A member is true if its option is in the subset.
struct MethodOptions {
    bool iterations;
    bool passes;
    bool quality;
    bool tolerance;
    bool fixed;
};

/// Method of distributing points: a row of the table in method.cpp. The functions are references, so that a row without
/// a function does not compile.
struct Method {
    std::string_view name;   ///< name in requests and answers
    std::string_view title;  ///< name shown to users
    /// Maximum number of sites. One core places this number in about a third of the default time-out. Fast methods have
    /// no limit of their own.
    std::size_t max_sites;
    int iterations;         ///< default number of iterations
    MethodOptions options;  ///< options that the method supports
    /// Estimates the cost of a run; `is_uniform` states whether the density is uniform.
    Estimate (&cost)(const Options& options, bool is_uniform);
    decltype(distribute)& run;
};

/// Returns all methods; the first is the default.
std::span<const Method> methods();

/// Returns the names of the MethodOptions that a method supports.
std::vector<std::string_view> option_names(const Method& method);

/// Reads a method by its name. Errors: Malformed.
Result<const Method*> read_method(const Input& input);

/// Adapts options to a method: if the number of iterations was not given, it is set to the method's default.
/// @param given  options that the request gives
/// Errors: Malformed for a given option that the method does not support; LimitExceeded for more sites than
/// method.max_sites. Error::field is a JSON Pointer.
Result<void> settle_method(const Method& method, const MethodOptions& given, Options& options);

}  // namespace ccdt::api
