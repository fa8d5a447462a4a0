#include "server/work/passage.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace ccdt::server {
namespace {

using Clock = Passage::Clock;
using std::chrono::seconds;

Clock::time_point later() {
    return Clock::now() + seconds(60);
}

class PassageTest : public testing::Test {
protected:
    /// Takes all pieces until the end.
    std::string take_all() {
        std::string text;
        while (!passage_.is_over())
            if (const auto piece = passage_.pop(later())) text += *piece;
        return text;
    }

    MemoryBudget memory_{1'000};
    Passage passage_{seconds(0)};
};

TEST_F(PassageTest, TransfersPiecesInOrder) {
    std::jthread worker([this] {
        for (int i = 0; i < 1'000; ++i) EXPECT_TRUE(passage_.push(std::to_string(i)));
        passage_.close({}, {1, 2, 3}, memory_);
    });
    std::string expected;
    for (int i = 0; i < 1'000; ++i) expected += std::to_string(i);
    EXPECT_EQ(take_all(), expected);
    EXPECT_TRUE(passage_.outcome());
    EXPECT_EQ(passage_.timings().encode, 3);
}

TEST_F(PassageTest, WaitsForPieces) {
    EXPECT_FALSE(passage_.pop(Clock::now()));
    EXPECT_FALSE(passage_.is_over());
    std::jthread worker([this] { passage_.close({}, {}, memory_); });
    EXPECT_FALSE(passage_.pop(later()));
    EXPECT_TRUE(passage_.is_over());
}

TEST_F(PassageTest, BuffersTheRestForASlowClient) {
    const std::string piece(Passage::kMostHeld, 'x');
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(passage_.push(piece));
    passage_.close({}, {}, memory_);
    EXPECT_EQ(memory_.taken(), 3 * piece.size());
    EXPECT_EQ(take_all().size(), 3 * piece.size());
}

TEST(Passage, MakesTheWorkerWaitForTheClient) {
    Passage passage(seconds(60));
    MemoryBudget memory{1'000};
    const std::string piece(Passage::kMostHeld, 'x');
    EXPECT_TRUE(passage.push(piece));
    std::jthread worker([&] {
        EXPECT_TRUE(passage.push("y"));
        passage.close({}, {}, memory);
    });
    EXPECT_EQ(passage.pop(later()), piece);
    EXPECT_EQ(passage.pop(later()), "y");
    EXPECT_FALSE(passage.pop(later()));
    EXPECT_TRUE(passage.is_over());
}

TEST_F(PassageTest, KeepsTheFirstOutcome) {
    passage_.close(failure(ErrorCode::Internal, "broken"), {}, memory_);
    passage_.close({}, {}, memory_);
    ASSERT_FALSE(passage_.outcome());
    EXPECT_EQ(passage_.outcome().error().message, "broken");
}

TEST_F(PassageTest, StopsTheComputationWhenAbandoned) {
    EXPECT_TRUE(passage_.push("x"));
    passage_.abandon();
    EXPECT_TRUE(passage_.stop().stop_requested());
    const auto pushed = passage_.push("y");
    ASSERT_FALSE(pushed);
    EXPECT_EQ(pushed.error().code, ErrorCode::Stopped);
}

}  // namespace
}  // namespace ccdt::server
