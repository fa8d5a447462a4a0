// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ccdt/control.h"
#include "ccdt/domain.h"
#include "ccdt/exception.h"
#include "ccdt/sample.h"
#include "core/base/result.h"
#include "core/base/thread_executor.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt::v2 {

/// Throws an error of core as an Exception.
[[noreturn]] void raise(const ccdt::Error& error);

[[noreturn]] void raise(FailureCode code, const std::string& message, std::string field);

/// Throws if an option is not in its range. NaN is in no range.
void check_range(double value, double min, double max, const char* name);

/// Returns the value of a result. Throws its error.
/// @param prefix  prepended to the field of the error, if the error has one
template <class T>
T value_of(ccdt::Result<T> result, std::string_view prefix = {}) {
    if (result) return *std::move(result);
    ccdt::Error error = std::move(result.error());
    if (!error.field.empty()) error.field.insert(0, prefix);
    raise(error);
}

/// The threads of one computation, and the caller's Control as core needs it.
class Execution {
public:
    explicit Execution(const Control& control);

    const ccdt::Control& control() const { return control_; }
    ccdt::Executor& executor() { return executor_; }

    /// Throws if a stop was requested.
    void check_stop() const;

private:
    ccdt::ThreadExecutor executor_;
    ccdt::Control control_;
};

std::vector<Point> points_of(std::span<const ccdt::Point> points);

/// Converts points. Throws if a coordinate is not finite.
/// @param field  field of the exception, to which the index of the point is appended
std::vector<ccdt::Point> core_points(std::span<const Point> points, std::string_view field);

/// Converts points in space between the types of the library and of core.
template <class To, class From>
std::vector<To> converted(const std::vector<From>& points) {
    std::vector<To> result;
    result.reserve(points.size());
    for (const From& p : points) result.push_back({p.x, p.y, p.z});
    return result;
}

ccdt::Quality core_quality(Quality quality);

/// Builds a domain. Throws for an invalid domain.
/// @param repair  whether invalid polygons are repaired
ccdt::RepairedDomain make_domain(const Domain& domain, bool repair, const std::stop_token& stop);

}  // namespace ccdt::v2
