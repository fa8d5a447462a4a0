// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/run_options.h"

#include <array>

namespace ccdt::api {
namespace {

constexpr std::uint64_t kMaxIterations = 1000;
constexpr std::uint64_t kMaxPasses = 100;

/// Values of the option `quality`. The last value, `stealthy`, is available for points, but not for halftones.
constexpr std::array<Choice<Quality>, 4> kQualities = {{{"draft", Quality::Draft},
                                                        {"standard", Quality::Standard},
                                                        {"best", Quality::Best},
                                                        {"stealthy", Quality::Stealthy}}};

constexpr std::array<Choice<OnStop>, 2> kOnStops = {{{"error", OnStop::Error}, {"partial", OnStop::Partial}}};

}  // namespace

std::span<const Choice<Quality>> qualities() {
    return kQualities;
}

Result<void> read_seed(const Input& input, Options& options) {
    return assign(options.seed, read_integer(input, 0, kMaxInteger));
}

Result<void> read_iterations(const Input& input, Options& options) {
    return assign(options.iterations, read_integer(input, 0, kMaxIterations));
}

Result<void> read_passes(const Input& input, Options& options) {
    return assign(options.passes, read_integer(input, 1, kMaxPasses));
}

Result<void> read_quality(const Input& input, Options& options) {
    return assign(options.quality, read_choice<Quality>(input, qualities()));
}

Result<void> read_halftone_quality(const Input& input, Options& options) {
    return assign(options.quality, read_choice<Quality>(input, qualities().first(kQualities.size() - 1)));
}

Result<OnStop> read_on_deadline(const Input& input) {
    return read_choice<OnStop>(input, kOnStops);
}

}  // namespace ccdt::api
