#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/run/options.h"
#include "core/result.h"
#include "server/work/memory_budget.h"

namespace ccdt::server {

/// A body on its way in pieces, from the worker that has it computed to the connection that sends it.
///
/// A client that takes pieces as they come has next to nothing held for it. One that is slow keeps the worker waiting
/// for a little only: then the rest is taken in, which the memory that the computation had has room for, and the worker
/// is free. May be used from both threads.
class Passage {
public:
    using Clock = std::chrono::steady_clock;

    /// Bytes that are held before the worker waits, and how long it waits in all.
    static constexpr std::size_t kMostHeld = std::size_t{4} << 20;
    static constexpr std::chrono::seconds kPatience{5};

    explicit Passage(Clock::duration patience = kPatience) : patience_(patience) {}

    /// Takes a piece. Errors: Stopped if nobody takes any more.
    Result<void> push(std::string_view piece);

    /// Ends the body, unless it has ended. What is held then has a lease of its own.
    /// @param outcome  an error: the body is not whole
    void close(Result<void> outcome, const api::Timings& timings, MemoryBudget& memory);

    /// Waits for a piece.
    /// @returns  none if there was none until then, or there will be no more
    std::optional<std::string> pop(Clock::time_point until);

    /// Whether all pieces were taken.
    bool is_over() const;

    /// How the body ended, once it is over, and what it took.
    Result<void> outcome() const;
    api::Timings timings() const;

    /// Takes no more pieces, and has the computation stopped.
    void abandon();

    /// Stops what computes.
    std::stop_source& stop() { return stop_; }

private:
    mutable std::mutex mutex_;  ///< guards the rest
    std::condition_variable came_;
    std::condition_variable went_;
    std::deque<std::string> pieces_;
    std::size_t held_ = 0;      ///< bytes
    Clock::duration patience_;  ///< what is left of it
    bool closed_ = false;
    bool abandoned_ = false;
    Result<void> outcome_;
    api::Timings timings_;
    std::stop_source stop_;
    MemoryBudget::Lease lease_;
};

}  // namespace ccdt::server
