// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/convergence.h"

#include "api/text/numbers.h"

namespace ccdt::server {

std::string doubt_about(const api::Answer& answer, std::string_view path, int iterations, double variation) {
    constexpr std::size_t kMin = 1'000;
    constexpr int kEnough = 5;
    constexpr double kLargest = .5;
    const bool is_good = variation <= kLargest;
    if (is_good || path != "/sample" || answer.sites < kMin || iterations < kEnough || answer.partial) return {};
    std::string remark = std::to_string(answer.sites) + " sites of /sample have a capacity variation of ";
    api::append_shortest(remark, variation);
    return remark + " after " + std::to_string(iterations) + " iterations";
}

}  // namespace ccdt::server
