// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <vector>

#include "core/ccdt/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"

namespace ccdt::bench {

/// Milliseconds of each part of one computation.
struct Stages {
    double start = 0;        ///< where sites are drawn, the border
    double triangulate = 0;  ///< inserting them
    double capacity = 0;     ///< exact integrals and goals
    double geometry = 0;     ///< passes
    double flips = 0;
};

/// Does what distribute() does, with a clock between the parts.
Stages time_stages(const Domain& domain, const Density& density, const Options& options);

class Clock {
public:
    /// Milliseconds since it was made or last asked.
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
