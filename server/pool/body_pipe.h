// SPDX-License-Identifier: GPL-3.0-or-later
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
#include "core/base/result.h"
#include "server/pool/memory_budget.h"

namespace ccdt::server {

/// A pipe that passes a body in pieces from the worker that computes it to the connection that sends it.
///
/// If the client receives fast enough, almost nothing is buffered. A slow client makes the worker wait, for at most
/// kPatience in total. Afterwards, the worker does not wait for the client any more: the remaining body is buffered in
/// the memory reserved for the computation. Both threads may call all members.
class BodyPipe {
public:
    using Clock = std::chrono::steady_clock;

    /// Number of buffered bytes at which push() begins to wait.
    static constexpr std::size_t kMaxHeld = std::size_t{4} << 20;

    /// Limit of the worker's total waiting time.
    static constexpr std::chrono::seconds kPatience{5};

    explicit BodyPipe(Clock::duration patience = kPatience) : patience_(patience) {}

    /// Appends a piece. Errors: Stopped if the reader has abandoned the pipe.
    Result<void> push(std::string_view piece);

    /// Ends the body; only the first call has an effect. The reservation of the computation ends after this call, so
    /// the bytes that are still buffered are reserved in `memory`.
    /// @param outcome  an error: the body is incomplete
    void close(Result<void> outcome, const api::Timings& timings, MemoryBudget& memory);

    /// Takes the next piece, and waits for it if necessary.
    /// @returns  none if no piece has arrived by `until`, or if the body has ended
    std::optional<std::string> pop(Clock::time_point until);

    /// Whether the body has ended and all pieces were taken.
    bool is_over() const;

    /// Returns the outcome of the body, once it is over, and the timings of its computation.
    Result<void> outcome() const;
    api::Timings timings() const;

    /// Stops the computation, and makes further push() calls fail.
    void abandon();

    /// Returns the source of the computation's stop token.
    std::stop_source& stop() { return stop_; }

private:
    mutable std::mutex mutex_;  ///< guards the members below
    std::condition_variable filled_;
    std::condition_variable drained_;
    std::deque<std::string> pieces_;
    std::size_t held_ = 0;      ///< in bytes
    Clock::duration patience_;  ///< remaining waiting time
    bool closed_ = false;
    bool abandoned_ = false;
    Result<void> outcome_;
    api::Timings timings_;
    std::stop_source stop_;
    MemoryBudget::Lease lease_;
};

}  // namespace ccdt::server
