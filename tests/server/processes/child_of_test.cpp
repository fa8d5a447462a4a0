// SPDX-License-Identifier: GPL-3.0-or-later
/// A program that the tests of child programs spawn. Its first argument names the action.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <sys/socket.h>
#include <unistd.h>

#include "server/processes/child_program.h"

namespace {

constexpr int kSocket = ccdt::server::ChildProgram::kSocket;

/// Describes the files and signals that the process has inherited, on one line.
std::string inherited() {
    std::string told = "files:";
    for (int fd = 0; fd < 100; ++fd) {
        std::error_code error;
        const auto target = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd), error);
        if (error || fd == STDERR_FILENO) continue;
        told += " " + std::to_string(fd) + (target == "/dev/null" ? "=null" : "");
    }
    sigset_t blocked;
    sigprocmask(SIG_SETMASK, nullptr, &blocked);
    told += sigismember(&blocked, SIGWINCH) == 1 ? " blocked" : "";
    told += std::signal(SIGPIPE, SIG_DFL) == SIG_DFL ? "" : " ignored";
    told += getpgid(0) == getpid() ? " own group" : "";
    for (const char* name : {"CCDT_SECRET", "NO_SECRET"})
        told += std::getenv(name) != nullptr ? std::string(" ") + name : "";
    return told;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string_view order = argc > 1 ? argv[1] : "";
    if (order == "tell") {
        const std::string told = inherited();
        send(kSocket, told.data(), told.size(), 0);
    }
    if (order == "find") {
        const auto found = ccdt::server::find_program(argv[2]);
        std::puts(found ? found->c_str() : found.error().message.c_str());
    }
    if (order == "start") {
        const auto started = ccdt::server::spawn_sibling(argv[2], ccdt::server::UniqueFd());
        std::puts(started ? "started" : started.error().message.c_str());
    }
    if (order == "crash") std::raise(SIGKILL);
    char byte = 0;
    if (order == "wait") static_cast<void>(recv(kSocket, &byte, 1, 0));
    return argc - 1;
}
