// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/thread_share.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

TEST(ThreadShare, GivesASingleComputationAllThreads) {
    EXPECT_EQ(threads_for_each(8, 0, 100), 8U);
    EXPECT_EQ(threads_for_each(8, 1, 100), 8U);
    EXPECT_EQ(threads_for_each(1, 1, 100), 1U);
}

TEST(ThreadShare, NeverLendsMoreThreadsThanExist) {
    for (std::size_t workers = 1; workers <= 16; ++workers) {
        for (std::size_t running = 1; running <= workers; ++running) {
            const std::size_t each = threads_for_each(workers, running, 100);
            EXPECT_LE(each * running, workers);
            EXPECT_GT((each + 1) * running, workers) << "nor fewer than can be had";
        }
    }
}

TEST(ThreadShare, LeavesEachComputationOneThread) {
    EXPECT_EQ(threads_for_each(2, 3, 100), 1U) << "with one that is short besides the workers'";
    EXPECT_EQ(threads_for_each(16, 17, 100), 1U);
}

TEST(ThreadShare, RespectsTheLimitPerRequest) {
    EXPECT_EQ(threads_for_each(16, 1, 4), 4U);
    EXPECT_EQ(threads_for_each(16, 8, 4), 2U);
    EXPECT_EQ(threads_for_each(16, 1, 1), 1U);
}

}  // namespace
}  // namespace ccdt::server
