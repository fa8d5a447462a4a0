#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace ccdt {

/// Those who work on one computation together. What they do is divided by the input alone, never by their number, so
/// that results do not depend on it.
class Team {
public:
    virtual ~Team() = default;

    /// Calls task(0) to task(count - 1), each once, in any order, several at the same time, and returns when all have
    /// ended. Tasks must not touch what another one writes, nor call this.
    ///
    /// What a task throws is thrown here, of several that of the lowest number; others may then not be called.
    virtual void run(std::size_t count, const std::function<void(std::size_t)>& task) = 0;
};

/// A team of the caller alone, who does one task after the other.
Team& alone();

/// Divides [0, count) into ranges of so many, the last one of less, and calls function(begin, end) with each.
template <class Function>
void for_ranges(Team& team, std::size_t count, std::size_t range, Function&& function) {
    if (count <= range) {
        if (count > 0) function(std::size_t{0}, count);
        return;
    }
    team.run((count + range - 1) / range,
             [&](std::size_t number) { function(number * range, std::min(count, (number + 1) * range)); });
}

}  // namespace ccdt
