// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/run_options.h"

#include <array>

namespace ccdt::api {
namespace {

constexpr std::array<Choice<Quality>, 4> kQualities = {{{"draft", Quality::Draft},
                                                        {"standard", Quality::Standard},
                                                        {"best", Quality::Best},
                                                        {"stealthy", Quality::Stealthy}}};

constexpr std::array<Choice<OnStop>, 2> kOnStops = {{{"error", OnStop::Error}, {"partial", OnStop::Partial}}};

}  // namespace

std::span<const Choice<Quality>> qualities() {
    return kQualities;
}

Result<OnStop> read_on_deadline(const Input& input) {
    return read_choice<OnStop>(input, kOnStops);
}

}  // namespace ccdt::api
