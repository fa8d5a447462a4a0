// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/operation/work_progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/api/files.h"

namespace ccdt::api {
namespace {

/// Runs no tasks, but lets enough time pass for a report.
class IdleExecutor : public Executor {
public:
    void run(std::size_t /*count*/, const std::function<void(std::size_t)>& /*task*/) override {
        std::this_thread::sleep_for(std::chrono::milliseconds(101));
    }
};

Decode decode_in_halves() {
    const auto decode = [](std::string_view, const Reading& reading, const std::stop_token&) -> Result<Picture> {
        reading.progress(0.5);
        return Picture{};
    };
    return {decode, {}};
}

TEST(WorkProgress, MovesInEveryStep) {
    std::vector<double> shown;
    IdleExecutor executor;
    const Control control{{}, [&](const Progress& progress) { shown.push_back(progress.done()); }, &executor};
    WorkProgress work(control, {.seconds = 0.5, .before = 0.2, .after = 0.15});
    const Decode decode = decode_in_halves(), observed = work.observe(decode);
    const Control own = work.control();
    const auto run = [&] { own.executor->run(1, [](std::size_t) {}); };

    ASSERT_TRUE(observed.grey(fixture("grey.jpg"), Reading(10'000), {}));
    EXPECT_EQ(shown.size(), 2U);
    run();
    EXPECT_EQ(shown.size(), 3U);
    EXPECT_LT(shown.back(), 0.5);  // before points move, and a part of the start
    for (int i = 0; i <= 3; ++i) {
        own.progress({.iteration = i, .iterations = 3, .variation = 0.1});
        run();
    }
    EXPECT_GT(shown.back(), 0.6);
    run();
    EXPECT_LT(shown.back(), 1);
    EXPECT_EQ(shown.size(), 12U);
    EXPECT_EQ(std::ranges::adjacent_find(shown, std::ranges::greater_equal()), shown.end());
}

TEST(WorkProgress, CountsDecodingOfUnknownShare) {
    std::vector<double> shown;
    const Control control{{}, [&](const Progress& progress) { shown.push_back(progress.done()); }};
    WorkProgress work(control, {.seconds = 1e-4});
    const Decode decode = decode_in_halves(), observed = work.observe(decode);
    ASSERT_TRUE(observed.grey(fixture("grey.jpg"), Reading(10'000), {}));
    const double decoded = shown.back();
    EXPECT_GT(decoded, 0);
    work.control().progress({.iteration = 1, .iterations = 2, .variation = 0.1});
    EXPECT_DOUBLE_EQ(shown.back(), decoded + (1 - decoded) * 0.6);
}

TEST(WorkProgress, ChangesNothingWithoutAnObserver) {
    const Control control;
    WorkProgress work(control, {.seconds = 1});
    EXPECT_EQ(work.control().executor, &inline_executor());
}

}  // namespace
}  // namespace ccdt::api
