#pragma once

#include <functional>
#include <stop_token>

namespace ccdt {

/// Does rounds of a polish until it is stopped.
/// @param round  called with the number of each, from 0
/// @param after  called after each round that was not stopped; may be empty
template <class Round>
void repeat(int rounds, const std::stop_token& stop, const std::function<void()>& after, Round&& round) {
    for (int i = 0; i < rounds && !stop.stop_requested(); ++i) {
        round(i);
        if (after && !stop.stop_requested()) after();
    }
}

}  // namespace ccdt
