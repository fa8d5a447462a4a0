// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/child_program.h"

#include <gtest/gtest.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
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

/// A temporary folder with the folders of an installed package. Its program bin/caller is a copy of ccdt_child_of_test.
class InstalledTree {
public:
    InstalledTree() {
        std::string name = std::filesystem::canonical(testing::TempDir()) / "ccdt-tree-XXXXXX";
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        root_ = name;
        std::filesystem::create_directories(root_ / "bin");
        std::filesystem::create_directories(root_ / "lib" / "ccdt");
        std::filesystem::copy_file(find_program("ccdt_child_of_test").value(), root_ / "bin" / "caller");
    }
    ~InstalledTree() { std::filesystem::remove_all(root_); }
    InstalledTree(const InstalledTree&) = delete;
    InstalledTree& operator=(const InstalledTree&) = delete;

    std::string path(const std::string& file) const { return root_ / file; }

    /// Creates an empty file that nobody may execute, and returns its path.
    std::string add(const std::string& file) const {
        EXPECT_TRUE(std::ofstream(path(file)));
        return path(file);
    }

    /// Runs bin/caller and returns its standard output.
    std::string run(const std::string& arguments) const {
        const std::unique_ptr<FILE, int (*)(FILE*)> output(popen((path("bin/caller ") + arguments).c_str(), "r"),
                                                           pclose);
        std::string text(1000, '\0');
        text.resize(output ? std::fread(text.data(), 1, text.size(), output.get()) : 0);
        return text;
    }

private:
    std::filesystem::path root_;
};

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
    sigset_t resize, before;
    sigemptyset(&resize);
    sigaddset(&resize, SIGWINCH);
    pthread_sigmask(SIG_BLOCK, &resize, &before);
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
    EXPECT_EQ(describe_end(spawn(make_sockets().theirs, {"two", "arguments"}).value().wait()), "exited with 2");
    const auto crashed = spawn(make_sockets().theirs, {"crash"}).value().wait();
    EXPECT_EQ(describe_end(crashed), "was killed by signal 9 (Killed)");
    EXPECT_TRUE(is_killed_from_outside(crashed));
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
    EXPECT_EQ(describe_end(child->wait()), "exited with 1");
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
                EXPECT_EQ(describe_end(child->wait()), "exited with 1");
            }
        });
    }
}

TEST(ChildProgram, ReportsAMissingFile) {
    const auto child = spawn_sibling("ccdt-no-such-program", make_sockets().theirs);
    ASSERT_FALSE(child);
    EXPECT_EQ(child.error().code, ErrorCode::Internal);
    EXPECT_NE(child.error().message.find("/lib/ccdt/ccdt-no-such-program exists"), std::string::npos);
}

TEST(ChildProgram, NamesAFileThatCannotBeExecuted) {
    const InstalledTree tree;
    const std::string file = tree.add("lib/ccdt/a-file");
    EXPECT_EQ(tree.run("start a-file"), "cannot start " + file + ": Permission denied\n");
}

TEST(FindProgram, PrefersTheFolderOfTheCaller) {
    const InstalledTree tree;
    const std::string in_lib = tree.add("lib/ccdt/helper");
    EXPECT_EQ(tree.run("find helper"), in_lib + "\n");
    const std::string beside = tree.add("bin/helper");
    EXPECT_EQ(tree.run("find helper"), beside + "\n");
}

TEST(FindProgram, NamesBothFoldersOfAMissingFile) {
    const InstalledTree tree;
    EXPECT_EQ(tree.run("find helper"), "cannot find helper: neither " + tree.path("bin/helper") + " nor " +
                                           tree.path("lib/ccdt/helper") + " exists\n");
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
