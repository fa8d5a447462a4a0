// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/body_pipe.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using Clock = BodyPipe::Clock;
using std::chrono::seconds;

Clock::time_point later() {
    return Clock::now() + test::kPatience;
}

class BodyPipeTest : public testing::Test {
protected:
    /// Takes all pieces until the end.
    std::string take_all() {
        std::string text;
        EXPECT_TRUE(test::wait_until("the end of the body", [&] {
            if (const auto piece = pipe_.pop(later())) text += *piece;
            return pipe_.is_over();
        }));
        return text;
    }

    MemoryBudget memory_{1'000};
    BodyPipe pipe_{seconds(0)};
};

TEST_F(BodyPipeTest, TransfersPiecesInOrder) {
    std::jthread worker([this] {
        for (int i = 0; i < 1'000; ++i) EXPECT_TRUE(pipe_.push(std::to_string(i)));
        pipe_.close({}, {.encode = 3}, memory_);
    });
    std::string expected;
    for (int i = 0; i < 1'000; ++i) expected += std::to_string(i);
    EXPECT_EQ(take_all(), expected);
    EXPECT_TRUE(pipe_.outcome());
    EXPECT_EQ(pipe_.timings().encode, 3);
}

TEST_F(BodyPipeTest, WaitsForPieces) {
    EXPECT_FALSE(pipe_.pop(Clock::now()));
    EXPECT_FALSE(pipe_.is_over());
    std::jthread worker([this] { pipe_.close({}, {}, memory_); });
    EXPECT_FALSE(pipe_.pop(later()));
    EXPECT_TRUE(pipe_.is_over());
}

TEST_F(BodyPipeTest, BuffersTheRestForASlowClient) {
    const std::string piece(BodyPipe::kMaxHeld, 'x');
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(pipe_.push(piece));
    pipe_.close({}, {}, memory_);
    EXPECT_EQ(memory_.reserved(), 3 * piece.size());
    EXPECT_EQ(take_all().size(), 3 * piece.size());
}

TEST(BodyPipe, MakesTheWorkerWaitForTheClient) {
    BodyPipe pipe(seconds(60));
    MemoryBudget memory{1'000};
    const std::string piece(BodyPipe::kMaxHeld, 'x');
    EXPECT_TRUE(pipe.push(piece));
    std::jthread worker([&] {
        EXPECT_TRUE(pipe.push("y"));
        pipe.close({}, {}, memory);
    });
    EXPECT_EQ(pipe.pop(later()), piece);
    EXPECT_EQ(pipe.pop(later()), "y");
    EXPECT_FALSE(pipe.pop(later()));
    EXPECT_TRUE(pipe.is_over());
}

TEST_F(BodyPipeTest, KeepsTheFirstOutcome) {
    pipe_.close(failure(ErrorCode::Internal, "broken"), {}, memory_);
    pipe_.close({}, {}, memory_);
    ASSERT_FALSE(pipe_.outcome());
    EXPECT_EQ(pipe_.outcome().error().message, "broken");
}

TEST_F(BodyPipeTest, StopsTheComputationWhenAbandoned) {
    EXPECT_TRUE(pipe_.push("x"));
    pipe_.abandon();
    EXPECT_TRUE(pipe_.stop().stop_requested());
    const auto pushed = pipe_.push("y");
    ASSERT_FALSE(pushed);
    EXPECT_EQ(pushed.error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt::server
