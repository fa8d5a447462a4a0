// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/body.h"

#include <algorithm>
#include <utility>

namespace ccdt::api {
namespace {

/// Number of bytes that are usually written between two calls of flush().
constexpr std::size_t kFlushInterval = std::size_t{1} << 20;

}  // namespace

void Body::expect(std::size_t bytes) {
    text_.reserve(sink_ == nullptr ? bytes : std::min(bytes, kMaxInMemory + kFlushInterval));
}

bool Body::flush() {
    if (sink_ != nullptr && text_.size() >= (begun_ ? kPiece : kMaxInMemory)) flush_all();
    return written_.has_value();
}

void Body::flush_all() {
    if (!std::exchange(begun_, true)) {
        Answer head = *head_;
        // A stop may have ended the search for a shorter path, so another run may give other bytes.
        head.repeats = head.repeats && !path_stop_.stop_requested();
        head.plot = plot_;
        written_ = sink_->begin(head);
    }
    for (std::string_view rest = text_; !rest.empty() && written_; rest.remove_prefix(std::min(kPiece, rest.size())))
        written_ = sink_->write(rest.substr(0, kPiece));
    text_.clear();
}

Result<Answer> Body::finish(Answer answer) {
    if (begun_) {
        flush_all();
    } else {
        answer.body = std::move(text_);
        answer.repeats = answer.repeats && !path_stop_.stop_requested();
    }
    answer.plot = plot_;
    answer.streamed = begun_;
    if (!written_) return tl::unexpected(written_.error());
    return answer;
}

}  // namespace ccdt::api
