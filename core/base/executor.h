// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace ccdt {

/// Runs the tasks of one computation. The division of work into tasks depends on the input alone, never on the number
/// of threads. So the results do not depend on the number of threads either.
class Executor {
public:
    virtual ~Executor() = default;

    /// Calls task(0) to task(count - 1), each once, in any order, possibly in parallel. Returns after all tasks have
    /// ended. A task must not access data that another task writes, and must not call run().
    ///
    /// If tasks throw exceptions, rethrows the exception of the task with the lowest number. After an exception, tasks
    /// that have not begun may be skipped.
    virtual void run(std::size_t count, const std::function<void(std::size_t)>& task) = 0;
};

/// Returns an executor that runs all tasks in the calling thread, one after the other.
Executor& inline_executor();

/// Divides [0, count) into ranges of `range` numbers, the last one possibly shorter. Calls function(begin, end) for
/// each range, possibly in parallel.
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
