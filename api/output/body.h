// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

#include "api/run/options.h"
#include "core/result.h"

namespace ccdt::api {

/// Takes an answer whose body is too large to be held whole. Errors: the taker's own; nothing more is handed on then.
class BodyTaker {
public:
    virtual ~BodyTaker() = default;

    /// Takes all of an answer but its body; once, before the first piece.
    virtual Result<void> begin(const Answer& head) = 0;

    /// Takes a piece of the body, of at most Body::kPiece bytes.
    virtual Result<void> take(std::string_view piece) = 0;
};

/// Body of an answer in the making. Up to kWhole bytes are held; of a larger one pieces are handed on as they are
/// written, if there is somebody to take them.
class Body {
public:
    static constexpr std::size_t kWhole = std::size_t{4} << 20;
    static constexpr std::size_t kPiece = std::size_t{256} << 10;

    /// Makes one that is held whole, however large it gets.
    Body() = default;

    /// @param head   of the answer
    /// @param taker  null: nobody
    /// @param hurry  stopped before the first piece is handed on, the answer is told not to repeat
    /// Head and taker must outlive it.
    Body(const Answer& head, BodyTaker* taker, std::stop_token hurry)
        : head_(&head), taker_(taker), hurry_(std::move(hurry)) {}

    /// Text to write to; now and then hand_on() is to be called.
    std::string& text() { return text_; }

    /// Makes room for so many bytes in all.
    void expect(std::size_t bytes);

    /// Has the answer tell how long a plotter draws it; before anything is handed on.
    void tell_plot(double seconds) { plot_seconds_ = seconds; }

    /// Hands on what was written, if that is enough.
    /// @returns  false if nobody takes any more: all further writing is in vain
    bool hand_on();

    /// Hands on the rest of what was begun to be handed on; what was not is the answer's body.
    /// Errors: those of the taker.
    Result<Answer> finish(Answer answer);

private:
    void hand_all_on();

    const Answer* head_ = nullptr;
    BodyTaker* taker_ = nullptr;
    std::stop_token hurry_;
    std::string text_;
    std::optional<double> plot_seconds_;
    bool begun_ = false;
    Result<void> taken_;
};

/// Chooses after how many elements of a list hand_on() is called again.
/// @param extra  bytes that each takes besides a few numbers
inline std::size_t stride_of(std::size_t extra) {
    constexpr std::size_t kMost = 4'096;
    return std::clamp(Body::kPiece / (extra + 1), std::size_t{1}, kMost);
}

}  // namespace ccdt::api
