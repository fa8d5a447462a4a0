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
#include "core/base/result.h"

namespace ccdt::api {

/// Receives an answer with a large body in pieces. After a function has returned an error, no function is called again.
class BodySink {
public:
    virtual ~BodySink() = default;

    /// Receives the answer without its body. Called once, before the first piece.
    virtual Result<void> begin(const Answer& head) = 0;

    /// Receives a piece of the body, of at most Body::kPiece bytes.
    virtual Result<void> write(std::string_view piece) = 0;
};

/// Body of an answer that is being written. A body of up to kMaxInMemory bytes is kept in memory. A larger body goes to
/// the sink, if there is one, in pieces while it is written.
class Body {
public:
    static constexpr std::size_t kMaxInMemory = std::size_t{4} << 20;
    static constexpr std::size_t kPiece = std::size_t{256} << 10;

    /// Creates a body that is kept in memory, however large it gets.
    Body() = default;

    /// @param head       the answer without its body
    /// @param sink       null: the whole body is kept in memory
    /// @param path_stop  token that ends the search for short paths early; if it is stopped before the first piece is
    ///                   passed on, the answer is marked as not repeatable
    /// The head and the sink must outlive this object.
    Body(const Answer& head, BodySink* sink, std::stop_token path_stop)
        : head_(&head), sink_(sink), path_stop_(std::move(path_stop)) {}

    /// Returns the text to which a writer appends. The writer must call flush() from time to time.
    std::string& text() { return text_; }

    /// Reserves memory for a body of `bytes` bytes or, with a sink, for the part of it that is in memory at once.
    void expect(std::size_t bytes);

    /// Sets the size of a drawing by a plotter. Must be called before the first piece is passed on.
    void set_plot(const PlotSize& plot) { plot_ = plot; }

    /// Passes the text written so far to the sink, if there is one and the text has at least kMaxInMemory bytes or,
    /// after the first piece, at least kPiece bytes.
    /// @returns  false if the sink failed, so that further writing has no effect
    bool flush();

    /// Ends the body. If the sink has received a piece, passes the remaining text to the sink. Otherwise stores the
    /// text as the body of the answer. Errors: the errors of the sink.
    Result<Answer> finish(Answer answer);

private:
    void flush_all();

    const Answer* head_ = nullptr;
    BodySink* sink_ = nullptr;
    std::stop_token path_stop_;
    std::string text_;
    std::optional<PlotSize> plot_;
    bool begun_ = false;
    Result<void> written_;
};

/// Returns the number of list elements that a writer should write between two calls of flush().
/// @param extra  bytes of an element besides its numbers, such as the names in a line
inline std::size_t flush_stride(std::size_t extra) {
    constexpr std::size_t kMaxStride = 4'096;
    return std::clamp(Body::kPiece / (extra + 1), std::size_t{1}, kMaxStride);
}

}  // namespace ccdt::api
