#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "api/input/option_reader.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

/// How points are distributed.
enum class Method { Ccdt, Cvt, Odt, Ccvt, Random };

/// Which of the options that not every method has were given.
struct GivenOptions {
    bool iterations = false;
    bool passes = false;
    bool quality = false;
    bool tolerance = false;
};

/// The word of a request and of its answer.
std::string_view name_of(Method method);

Result<Method> read_method(const Input& input);

/// Makes options fit a method: iterations that were not given become as many as the method needs.
/// Errors: Malformed for a given option that the method does not have; LimitExceeded for more sites than it can
/// distribute in a third of the default timeout or so, on one core. The field is a JSON Pointer.
Result<void> settle_method(Method method, const GivenOptions& given, Options& options);

/// Distributes as distribute() does.
Result<Distribution> distribute_by(Method method, const Domain& domain, const Density& density, const Options& options,
                                   const Control& control);

}  // namespace ccdt::api
