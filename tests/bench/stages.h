// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <vector>

#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"

namespace ccdt::bench {

/// Durations of the stages of one computation, in milliseconds.
struct Stages {
    double start = 0;        ///< random initial sites, and vertices along the border
    double triangulate = 0;  ///< inserting the sites
    double capacity = 0;     ///< exact integrals and goals
    double geometry = 0;     ///< passes
    double flips = 0;
};

/// Performs the stages of distribute(), and measures the time of each stage.
Stages time_stages(const Domain& domain, const Density& density, const Options& options);

class Clock {
public:
    /// Returns the milliseconds since the previous call or the construction.
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
        last_ = now;
        return ms;
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

double median(std::vector<double> values);

}  // namespace ccdt::bench
