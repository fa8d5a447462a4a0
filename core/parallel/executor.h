// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace ccdt {

/// Runs the tasks of one computation. How work is divided into tasks depends on the input alone, never on the number of
/// threads, so that results do not depend on it.
class Executor {
public:
    virtual ~Executor() = default;

    /// Calls task(0) to task(count - 1), each once, in any order, possibly in parallel, and returns after all have
    /// ended. A task must not touch what another task writes, nor call run().
    ///
    /// Rethrows what a task throws; of several exceptions the one of the lowest task number. Other tasks may then not
    /// be called.
    virtual void run(std::size_t count, const std::function<void(std::size_t)>& task) = 0;
};

/// Returns an executor that runs all tasks in the calling thread, one after the other.
Executor& inline_executor();

/// Divides [0, count) into ranges of `range` numbers, the last one possibly shorter, and calls function(begin, end) for
/// each.
template <class Function>
void for_ranges(Executor& executor, std::size_t count, std::size_t range, Function&& function) {
    if (count <= range) {
        if (count > 0) function(std::size_t{0}, count);
        return;
    }
    executor.run((count + range - 1) / range,
                 [&](std::size_t number) { function(number * range, std::min(count, (number + 1) * range)); });
}

}  // namespace ccdt
