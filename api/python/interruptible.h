// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include <pybind11/pybind11.h>

#include "core/base/thread_executor.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::python {

/// Runs a computation on a thread of its own, while the calling thread waits without the interpreter's lock. Several
/// Python threads can compute at the same time. No thread outlives the call, so that the process may fork between
/// computations.
///
/// While it waits, the calling thread briefly takes the lock to handle signals and to report progress. If a signal
/// handler or `progress` raises an exception, the computation is stopped, and the exception is raised after its end.
///
/// @param threads   number of threads of the computation
/// @param progress  callable that receives the completed share of the work, 0 to 1; or None
/// @param work      computes the result from a Control
/// Throws what `work` throws, and py::error_already_set.
template <class Work>
auto run_interruptible(std::size_t threads, const pybind11::object& progress, Work work) {
    namespace py = pybind11;
    constexpr std::chrono::milliseconds kPoll{50};  // a person does not notice this delay of an interruption

    std::mutex mutex;
    std::condition_variable changed;
    double done = 0;  // guarded by `mutex`, like the next one
    bool is_over = false;

    ThreadExecutor executor(std::max<std::size_t>(threads, 1));
    std::stop_source stop;
    const auto report = [&](const Progress& state) {
        {
            const std::lock_guard lock(mutex);
            done = state.done();
        }
        changed.notify_one();
    };
    const Control control{stop.get_token(), report, &executor};
    std::optional<decltype(work(control))> result;
    std::exception_ptr failure;       // thrown by the computation
    std::exception_ptr interruption;  // thrown by Python
    {
        const py::gil_scoped_release release;
        const std::jthread worker([&] {
            try {
                result.emplace(work(control));
            } catch (...) {
                failure = std::current_exception();
            }
            const std::lock_guard lock(mutex);
            is_over = true;
            changed.notify_one();
        });
        double reported = 0;
        for (std::unique_lock lock(mutex);;) {
            changed.wait_for(lock, kPoll, [&] { return is_over || (done > reported && !interruption); });
            if (is_over) break;
            if (interruption) continue;
            const double share = done;
            lock.unlock();
            {
                const py::gil_scoped_acquire acquire;
                try {
                    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
                    if (share > reported && !progress.is_none()) progress(share);
                } catch (const py::error_already_set&) {
                    interruption = std::current_exception();
                    stop.request_stop();
                }
            }
            reported = share;
            lock.lock();
        }
    }
    if (interruption) std::rethrow_exception(interruption);
    if (failure) std::rethrow_exception(failure);
    return *std::move(result);
}

}  // namespace ccdt::python
