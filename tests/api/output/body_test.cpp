// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/body.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace ccdt::api {
namespace {

/// Takes at most `max_pieces` pieces.
class Sink : public BodySink {
public:
    explicit Sink(std::size_t max_pieces = 1'000'000) : max_pieces_(max_pieces) {}

    Result<void> begin(const Answer& head) override {
        heads.push_back(head);
        return {};
    }

    Result<void> write(std::string_view piece) override {
        if (pieces.size() == max_pieces_) return failure(ErrorCode::Stopped, "enough");
        pieces.emplace_back(piece);
        return {};
    }

    std::string all() const {
        std::string text;
        for (const std::string& piece : pieces) text += piece;
        return text;
    }

    std::vector<Answer> heads;
    std::vector<std::string> pieces;

private:
    std::size_t max_pieces_;
};

Answer head() {
    Answer answer;
    answer.media_type = "text/csv";
    return answer;
}

/// Returns a text of successive numbers, so that missing or reordered parts are detected.
std::string numbers(std::size_t size) {
    std::string text;
    for (int i = 0; text.size() < size; ++i) text += std::to_string(i) + ' ';
    text.resize(size);
    return text;
}

/// Writes a text in small parts, until it is complete or the sink refuses a piece.
/// @returns  number of bytes written
std::size_t write(Body& body, std::string_view text) {
    constexpr std::size_t kPart = 1'000;
    std::size_t written = 0;
    while (written < text.size() && body.flush()) {
        body.text() += text.substr(written, kPart);
        written = std::min(written + kPart, text.size());
    }
    return written;
}

TEST(Body, IsHeldInMemoryIfSmall) {
    const std::string text = numbers(Body::kMaxInMemory - 1);
    const Answer before = head();
    Sink sink;
    Body body(before, &sink, {});
    write(body, text);
    const auto answer = body.finish(before);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->body, text);
    EXPECT_FALSE(answer->streamed);
    EXPECT_TRUE(sink.heads.empty());
}

TEST(Body, IsHeldInMemoryWithoutReceiver) {
    const std::string text = numbers(2 * Body::kMaxInMemory);
    const Answer before = head();
    Body body(before, nullptr, {});
    write(body, text);
    const auto answer = body.finish(before);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->body, text);
}

TEST(Body, IsStreamedInPiecesIfLarge) {
    const std::string text = numbers(2 * Body::kMaxInMemory + 12'345);
    const Answer before = head();
    Sink sink;
    Body body(before, &sink, {});
    write(body, text);
    EXPECT_LT(body.text().size(), Body::kPiece + 2'000);
    const auto answer = body.finish(before);
    ASSERT_TRUE(answer);
    EXPECT_TRUE(answer->streamed);
    EXPECT_TRUE(answer->body.empty());
    ASSERT_EQ(sink.heads.size(), 1U);
    EXPECT_EQ(sink.heads.front().media_type, "text/csv");
    EXPECT_TRUE(sink.heads.front().repeats);
    EXPECT_LE(std::ranges::max(sink.pieces, {}, &std::string::size).size(), Body::kPiece);
    EXPECT_EQ(sink.all(), text);
}

TEST(Body, StopsOnceReceiverStops) {
    const std::string text = numbers(4 * Body::kMaxInMemory);
    const Answer before = head();
    Sink sink(20);
    Body body(before, &sink, {});
    EXPECT_LT(write(body, text), 2 * Body::kMaxInMemory);
    const auto answer = body.finish(before);
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().code, ErrorCode::Stopped);
}

TEST(Body, ReportsIfNotReproducibleBecauseHurried) {
    std::stop_source path_stop;
    const Answer before = head();
    Sink sink;
    Body large(before, &sink, path_stop.get_token()), small(before, &sink, path_stop.get_token());
    path_stop.request_stop();
    write(large, numbers(Body::kMaxInMemory + 10'000));
    ASSERT_EQ(sink.heads.size(), 1U);
    EXPECT_FALSE(sink.heads.front().repeats);
    EXPECT_FALSE(small.finish(before)->repeats);
}

}  // namespace
}  // namespace ccdt::api
