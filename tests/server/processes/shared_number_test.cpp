// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/shared_number.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <utility>

namespace ccdt::server {
namespace {

TEST(SharedNumber, IsReadByOtherProcesses) {
    auto number = SharedNumber::create(3);
    ASSERT_TRUE(number) << number.error().message;
    const SharedNumberReader read(number->file());
    EXPECT_EQ(read.load(1), 3U);
    const pid_t other = fork();
    if (other == 0) {
        number->store(5);
        _exit(0);
    }
    waitpid(other, nullptr, 0);
    EXPECT_EQ(read.load(1), 5U);
    EXPECT_EQ(number->load(), 5U);
    const SharedNumber moved = *std::move(number);
    EXPECT_EQ(moved.load(), 5U);
}

TEST(SharedNumber, IsReadOnlyForOtherProcesses) {
    const auto number = SharedNumber::create(3);
    ASSERT_TRUE(number);
    const UniqueFd copy(dup(number->file().get()));
    EXPECT_EQ(SharedPage(copy, PROT_READ | PROT_WRITE).get(), nullptr);
    EXPECT_LT(write(copy.get(), "1234", 4), 0);
    EXPECT_LT(ftruncate(copy.get(), 0), 0) << "which would end whoever reads it";
    EXPECT_EQ(number->load(), 3U);
}

TEST(SharedNumber, ReturnsADefaultWithoutAFile) {
    const SharedNumberReader none((UniqueFd()));
    EXPECT_EQ(none.load(7), 7U);
}

}  // namespace
}  // namespace ccdt::server
