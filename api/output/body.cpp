// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/body.h"

#include <algorithm>
#include <utility>

namespace ccdt::api {
namespace {

/// Number of bytes that are usually written between two calls of flush().
constexpr std::size_t kBetween = std::size_t{1} << 20;

}  // namespace

void Body::expect(std::size_t bytes) {
    text_.reserve(taker_ == nullptr ? bytes : std::min(bytes, kWhole + kBetween));
}

bool Body::flush() {
    if (taker_ != nullptr && text_.size() >= (begun_ ? kPiece : kWhole)) flush_all();
    return taken_.has_value();
}

void Body::flush_all() {
    if (!std::exchange(begun_, true)) {
        Answer head = *head_;
        // A stop may have ended the search for a shorter path, so another run may give other bytes.
        head.repeats = head.repeats && !path_stop_.stop_requested();
        head.plot_seconds = plot_seconds_;
        taken_ = taker_->begin(head);
    }
    for (std::string_view rest = text_; !rest.empty() && taken_; rest.remove_prefix(std::min(kPiece, rest.size())))
        taken_ = taker_->take(rest.substr(0, kPiece));
    text_.clear();
}

Result<Answer> Body::finish(Answer answer) {
    if (begun_) {
        flush_all();
    } else {
        answer.body = std::move(text_);
        answer.repeats = answer.repeats && !path_stop_.stop_requested();
    }
    answer.plot_seconds = plot_seconds_;
    answer.streamed = begun_;
    if (!taken_) return tl::unexpected(taken_.error());
    return answer;
}

}  // namespace ccdt::api
