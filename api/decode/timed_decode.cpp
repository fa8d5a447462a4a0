// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/decode/timed_decode.h"

#include <functional>

#include "api/run/stopwatch.h"

namespace ccdt::api {

namespace {

template <class Decoded, class... Arguments>
std::function<Decoded(Arguments...)> timed(const std::function<Decoded(Arguments...)>& function, double& spent) {
    if (!function) return {};
    return [&function, &spent](Arguments... arguments) {
        Stopwatch watch;
        auto decoded = function(arguments...);
        spent += watch.lap();
        return decoded;
    };
}

}  // namespace

Decode timed(const Decode& decode, double& spent) {
    return {timed(decode.grey, spent), timed(decode.colour, spent), timed(decode.surface, spent)};
}

}  // namespace ccdt::api
