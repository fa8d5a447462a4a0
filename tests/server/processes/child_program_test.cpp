// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/child_program.h"

#include <gtest/gtest.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

struct Pair {
    UniqueFd ours;
    UniqueFd theirs;
};

Pair make_sockets() {
    std::array<int, 2> ends{-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
    return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

Result<ChildProgram> spawn(UniqueFd socket, std::vector<std::string> arguments) {
    return spawn_sibling("ccdt_child_of_test", std::move(socket), std::move(arguments));
}

bool has_children() {
    return waitpid(-1, nullptr, WNOHANG) >= 0 || errno != ECHILD;
}

TEST(TestProgram, EndsWithItsRunner) {
    int signal = 0;
    ASSERT_EQ(prctl(PR_GET_PDEATHSIG, &signal), 0);
    EXPECT_EQ(signal, SIGKILL);
}

TEST(ChildProgram, InheritsOnlyItsSocket) {
    setenv("CCDT_SECRET", "1", 1);
    setenv("NO_SECRET", "1", 1);
    std::signal(SIGPIPE, SIG_IGN);
    sigset_t terminate, before;
    sigemptyset(&terminate);
    sigaddset(&terminate, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &terminate, &before);
    const UniqueFd other(dup(STDERR_FILENO));
    auto sockets = make_sockets();
    auto child = spawn(std::move(sockets.theirs), {"tell"});
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    std::signal(SIGPIPE, SIG_DFL);
    unsetenv("CCDT_SECRET");
    unsetenv("NO_SECRET");
    ASSERT_TRUE(child) << child.error().message;
    std::array<char, 1000> told{};
    ASSERT_GT(recv(sockets.ours.get(), told.data(), told.size() - 1, 0), 0);
    EXPECT_STREQ(told.data(), "files: 0=null 1=null 3 own group NO_SECRET");
}

TEST(ChildProgram, ReportsHowItEnded) {
    EXPECT_EQ(spawn(make_sockets().theirs, {"two", "arguments"}).value().wait(), "exited with 2");
    EXPECT_EQ(spawn(make_sockets().theirs, {"crash"}).value().wait(), "was killed by signal 9 (Killed)");
    EXPECT_FALSE(has_children());
}

TEST(ChildProgram, NoticesThatTheSocketWasClosed) {
    auto sockets = make_sockets();
    auto child = spawn(std::move(sockets.theirs), {"wait"});
    ASSERT_TRUE(child);
    pollfd polled{child->ended(), POLLIN, 0};
    EXPECT_EQ(poll(&polled, 1, 0), 0);
    sockets.ours.reset();
    const auto patience = std::chrono::milliseconds(test::kPatience);
    ASSERT_EQ(poll(&polled, 1, static_cast<int>(patience.count())), 1) << "waited for the end of the child";
    EXPECT_EQ(child->wait(), "exited with 1");
}

TEST(ChildProgram, IsKilledWithItsHandle) {
    auto sockets = make_sockets();
    {
        auto child = spawn(std::move(sockets.theirs), {"wait"});
        ASSERT_TRUE(child);
        const ChildProgram moved = *std::move(child);
        EXPECT_EQ(kill(moved.id(), 0), 0);
    }
    EXPECT_FALSE(has_children());
}

TEST(ChildProgram, IsSpawnedByManyThreads) {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) {
        threads.emplace_back([] {
            for (int round = 0; round < 5; ++round) {
                auto sockets = make_sockets();
                auto child = spawn(std::move(sockets.theirs), {"wait"});
                ASSERT_TRUE(child);
                sockets.ours.reset();  // ends the child, because no other child has inherited the socket
                EXPECT_EQ(child->wait(), "exited with 1");
            }
        });
    }
}

TEST(ChildProgram, NamesAMissingFile) {
    const auto child = spawn_sibling("ccdt-no-such-program", make_sockets().theirs);
    ASSERT_FALSE(child);
    EXPECT_EQ(child.error().code, ErrorCode::Internal);
    EXPECT_NE(child.error().message.find("/ccdt-no-such-program: No such file"), std::string::npos);
}

TEST(Backoff, GrowsWhileProcessesDieEarly) {
    using std::chrono::milliseconds;
    Backoff backoff;
    for (const int expected : {10, 20, 40, 80, 160, 320, 640, 1000, 1000})
        EXPECT_EQ(backoff.after(milliseconds(1)), milliseconds(expected));
    EXPECT_EQ(backoff.after(milliseconds(1001)), milliseconds(10));
    EXPECT_EQ(backoff.after(milliseconds(1000)), milliseconds(20));
}

}  // namespace
}  // namespace ccdt::server
