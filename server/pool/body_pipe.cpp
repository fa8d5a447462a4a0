// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/body_pipe.h"

#include <algorithm>
#include <utility>

namespace ccdt::server {

Result<void> BodyPipe::push(std::string_view piece) {
    std::unique_lock lock(mutex_);
    const auto start = Clock::now();
    drained_.wait_until(lock, start + patience_, [this] { return abandoned_ || held_ < kMaxHeld; });
    patience_ -= std::min(patience_, Clock::now() - start);
    if (abandoned_) return failure(ErrorCode::Stopped, "the client no longer receives the answer");
    pieces_.emplace_back(piece);
    held_ += piece.size();
    filled_.notify_one();
    return {};
}

void BodyPipe::close(Result<void> outcome, const api::Timings& timings, MemoryBudget& memory) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    outcome_ = std::move(outcome);
    timings_ = timings;
    lease_ = memory.reserve_unconditionally(held_);
    closed_ = true;
    filled_.notify_one();
}

std::optional<std::string> BodyPipe::pop(Clock::time_point until) {
    std::unique_lock lock(mutex_);
    if (!filled_.wait_until(lock, until, [this] { return closed_ || !pieces_.empty(); }) || pieces_.empty())
        return std::nullopt;
    std::string piece = std::move(pieces_.front());
    pieces_.pop_front();
    held_ -= piece.size();
    drained_.notify_one();
    return piece;
}

bool BodyPipe::is_over() const {
    const std::lock_guard lock(mutex_);
    return closed_ && pieces_.empty();
}

Result<void> BodyPipe::outcome() const {
    const std::lock_guard lock(mutex_);
    return outcome_;
}

api::Timings BodyPipe::timings() const {
    const std::lock_guard lock(mutex_);
    return timings_;
}

void BodyPipe::abandon() {
    stop_.request_stop();
    const std::lock_guard lock(mutex_);
    abandoned_ = true;
    pieces_.clear();
    held_ = 0;
    drained_.notify_one();
}

}  // namespace ccdt::server
