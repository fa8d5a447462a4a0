// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/forked_children.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <csignal>
#include <optional>
#include <utility>

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/processes/child_program.h"
#include "server/processes/messages.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

constexpr int kPrepared = 7;

void report_status(const UniqueFd& socket, int status, std::chrono::microseconds) {
    static_cast<void>(send_message(socket.get(), bytes_of(status)));
}

/// Forks a child for each order, in a separate process, the supervisor. An order is the exit status of its child; if
/// negative, the child runs until the supervisor ends. The first file of an order is the socket of the child. The
/// supervisor writes to the second file, if any, when it has prepared for the next order.
[[noreturn]] void supervise(UniqueFd orders) {
    const pid_t supervisor = getpid();
    ForkedChildren children(std::move(orders), report_status);
    UniqueFd prepared;
    const auto prepare = [&] { report_status(prepared, kPrepared, {}); };
    int order = 0;
    while (auto files = children.wait_for_order(writable_bytes_of(order), prepare)) {
        const pid_t process = children.fork();
        if (process == 0 && order < 0) {
            prctl(PR_SET_PDEATHSIG, SIGKILL);
            if (getppid() == supervisor) pause();  // otherwise the supervisor has ended before the call
        }
        if (process == 0) _exit(order);
        children.add(process, std::move((*files)[0]));
        prepared = std::move((*files)[1]);
    }
    _exit(0);
}

/// Waits until a socket is readable.
void wait_for_news(const UniqueFd& socket) {
    pollfd polled{socket.get(), POLLIN, 0};
    const auto patience = std::chrono::milliseconds(test::kPatience);
    if (poll(&polled, 1, static_cast<int>(patience.count())) != 1)
        ADD_FAILURE() << test::waited_in_vain("a message").message();
}

/// Receives a number; none if the other end is closed.
std::optional<int> receive(const UniqueFd& socket) {
    wait_for_news(socket);
    int number = 0;
    if (receive_message(socket.get(), writable_bytes_of(number)) != sizeof(number)) return std::nullopt;
    return number;
}

class ForkedChildrenTest : public testing::Test {
protected:
    /// Sends an order; returns our end of the child's socket.
    UniqueFd order(int status) {
        auto child = *make_sockets(SOCK_SEQPACKET);
        auto prepared = *make_sockets(SOCK_SEQPACKET);
        const std::array files = {child.theirs.get(), prepared.theirs.get()};
        EXPECT_TRUE(send_message(orders_.get(), bytes_of(status), files));
        prepared_ = std::move(prepared.ours);
        return std::move(child.ours);
    }

    static pid_t start(SocketPair& sockets) {
        const pid_t process = fork();
        if (process != 0) return process;
        sockets.ours.reset();
        supervise(std::move(sockets.theirs));
    }

    SocketPair sockets_ = *make_sockets(SOCK_SEQPACKET);
    ChildProgram supervisor_{start(sockets_)};
    UniqueFd orders_ = std::move(sockets_.ours);
    UniqueFd prepared_;
};

TEST_F(ForkedChildrenTest, ReportsTheEndOfEachChild) {
    const UniqueFd first = order(1), second = order(2);
    EXPECT_EQ(WEXITSTATUS(receive(second).value_or(0)), 2);
    EXPECT_EQ(WEXITSTATUS(receive(first).value_or(0)), 1);
}

TEST_F(ForkedChildrenTest, KillsAChildThatNobodyWaitsFor) {
    const UniqueFd child = order(-1);
    EXPECT_EQ(receive(prepared_), kPrepared);
    ASSERT_EQ(shutdown(child.get(), SHUT_WR), 0);
    EXPECT_EQ(receive(child), std::nullopt);
    EXPECT_EQ(WEXITSTATUS(receive(order(3)).value_or(0)), 3);
}

TEST_F(ForkedChildrenTest, AnswersProbes) {
    const UniqueFd child = order(-1);
    const UniqueFd answer = send_probe(orders_.get());
    wait_for_news(answer);
    EXPECT_TRUE(is_answered(answer));
}

TEST_F(ForkedChildrenTest, EndsWithItsServer) {
    orders_.reset();
    sockets_.theirs.reset();
    EXPECT_EQ(describe_end(supervisor_.wait()), "exited with 0");
}

}  // namespace
}  // namespace ccdt::server
