// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/thread_executor.h"

#include <atomic>
#include <barrier>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace ccdt {
namespace {

TEST(ThreadExecutor, CallsEachTaskOnce) {
    for (const std::size_t size : {0, 1, 2, 3, 16}) {
        ThreadExecutor executor(size);
        for (const std::size_t count : {0, 1, 2, 7, 1000}) {
            std::vector<std::atomic<int>> calls(count);
            executor.run(count, [&](std::size_t number) { ++calls[number]; });
            for (const auto& each : calls) EXPECT_EQ(each, 1) << size << " threads, " << count << " tasks";
        }
    }
}

TEST(ThreadExecutor, RunsTasksInParallel) {
    // Three tasks that wait for each other end only if three threads run them.
    ThreadExecutor executor(3);
    std::barrier together(3);
    executor.run(3, [&](std::size_t) { together.arrive_and_wait(); });
}

TEST(ThreadExecutor, RespectsTheNumberOfThreads) {
    std::size_t size = 1;
    ThreadExecutor executor([&] { return size; });
    const auto own = std::this_thread::get_id();
    std::atomic<int> others = 0;
    executor.run(100, [&](std::size_t) { others += std::this_thread::get_id() == own ? 0 : 1; });
    EXPECT_EQ(others, 0);
    size = 2;
    std::barrier together(2);
    executor.run(2, [&](std::size_t) {
        together.arrive_and_wait();
        others += std::this_thread::get_id() == own ? 0 : 1;
    });
    EXPECT_EQ(others, 1);
}

TEST(ThreadExecutor, RethrowsTheExceptionOfTheFirstTask) {
    for (const std::size_t size : {1, 4}) {
        ThreadExecutor executor(size);
        try {
            executor.run(100, [](std::size_t number) {
                if (number == 5 || number == 7) throw std::runtime_error(std::to_string(number));
            });
            FAIL();
        } catch (const std::runtime_error& error) {
            EXPECT_STREQ(error.what(), "5");
        }
        std::atomic<int> calls = 0;
        executor.run(10, [&](std::size_t) { ++calls; });
        EXPECT_EQ(calls, 10) << "after a failure";
    }
}

TEST(ForRanges, CoversTheWholeRange) {
    ThreadExecutor executor(2);
    for (const std::size_t count : {0, 1, 9, 10, 11, 100}) {
        std::vector<int> calls(count, 0);
        for_ranges(executor, count, 10, [&](std::size_t begin, std::size_t end) {
            EXPECT_LE(end - begin, 10u);
            for (std::size_t i = begin; i < end; ++i) ++calls[i];
        });
        EXPECT_EQ(calls, std::vector<int>(count, 1));
    }
}

}  // namespace
}  // namespace ccdt
