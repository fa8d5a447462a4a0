#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "api/input/option_reader.h"
#include "api/run/estimate.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// Set of the options that not every method has.
struct MethodOptions {
    bool iterations;
    bool passes;
    bool quality;
    bool tolerance;
    bool fixed;
};

/// Method of distributing points: a row of the table in method.cpp. Functions are references, lest a row without one
/// compile.
struct Method {
    std::string_view name;   ///< in requests and answers
    std::string_view title;  ///< for people
    std::size_t max_sites;   ///< as many as it distributes in a third of the default timeout or so, on one core
    int iterations;          ///< unless a request gives them
    MethodOptions options;   ///< that it has
    Estimate (&cost)(const Options& options, bool is_uniform);
    decltype(distribute)& run;
};

/// All methods; the first is the default one.
std::span<const Method> methods();

/// Names of the options that a method has, of those that not every method has.
std::vector<std::string_view> option_names(const Method& method);

/// Reads a method by its name. Errors: Malformed.
Result<const Method*> read_method(const Input& input);

/// Makes options fit a method: iterations that were not given become as many as the method needs.
/// Errors: Malformed for a given option that the method does not have; LimitExceeded for more sites than it takes. The
/// field is a JSON Pointer.
Result<void> settle_method(const Method& method, const MethodOptions& given, Options& options);

}  // namespace ccdt::api
