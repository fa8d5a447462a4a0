// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/thread_executor.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

namespace ccdt {

namespace {

/// Spins for a short time until a condition is true. The condition usually becomes true soon, whereas waking a sleeping
/// thread takes tens of microseconds.
template <class Predicate>
void wait_awake(Predicate&& has_come) {
    constexpr auto kSoon = std::chrono::microseconds(50);
    const auto end = std::chrono::steady_clock::now() + kSoon;
    while (!has_come() && std::chrono::steady_clock::now() < end) continue;
}

}  // namespace

ThreadExecutor::ThreadExecutor(std::function<std::size_t()> size) : size_(std::move(size)) {}

ThreadExecutor::ThreadExecutor(std::size_t size) : ThreadExecutor([size] { return size; }) {}

ThreadExecutor::~ThreadExecutor() = default;

void ThreadExecutor::run(std::size_t count, const std::function<void(std::size_t)>& task) {
    const std::size_t helpers = std::min(std::max<std::size_t>(size_(), 1), count) - (count > 0 ? 1 : 0);
    if (helpers == 0) return inline_executor().run(count, task);
    start_helpers(helpers);
    Work work;
    work.count = count;
    work.task = &task;
    {
        const std::lock_guard lock(mutex_);
        work_ = &work;
        ++round_;
        open_slots_ = helpers;
    }
    wanted_.notify_all();
    work_on(work);
    {
        const std::lock_guard lock(mutex_);
        work_ = nullptr;
    }
    wait_awake([this] { return busy_ == 0; });
    std::unique_lock lock(mutex_);
    left_.wait(lock, [this] { return busy_ == 0; });
    if (work.failure) std::rethrow_exception(work.failure);
}

/// Starts threads until there are `helpers` of them.
void ThreadExecutor::start_helpers(std::size_t helpers) {
    try {
        while (helpers_.size() < helpers) {
            helpers_.emplace_back([this](const std::stop_token& stop) { help(stop); });
        }
    } catch (const std::system_error&) {  // no more threads available
    }
}

void ThreadExecutor::help(const std::stop_token& stop) {
    std::size_t done = 0;
    std::unique_lock lock(mutex_);
    while (wanted_.wait(lock, stop, [&] { return work_ != nullptr && round_ != done && open_slots_ > 0; })) {
        done = round_;
        --open_slots_;
        ++busy_;
        Work& work = *work_;
        lock.unlock();
        work_on(work);
        lock.lock();
        if (--busy_ == 0) left_.notify_one();
        lock.unlock();
        wait_awake([&] { return round_ != done; });
        lock.lock();
    }
}

void ThreadExecutor::work_on(Work& work) {
    for (std::size_t number = work.next++; number < work.count; number = work.next++) {
        try {
            (*work.task)(number);
        } catch (...) {
            const std::lock_guard lock(work.failing);
            if (!work.failure || number < work.failed) {
                work.failure = std::current_exception();
                work.failed = number;
            }
        }
    }
}

}  // namespace ccdt
