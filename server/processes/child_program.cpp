// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/child_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

/// Actions that posix_spawn performs in the child before the program starts.
class SpawnActions {
public:
    explicit SpawnActions(int socket) {
        posix_spawn_file_actions_init(&actions_);
        posix_spawn_file_actions_adddup2(&actions_, socket, ChildProgram::kSocket);
        for (const int stream : {STDIN_FILENO, STDOUT_FILENO})
            posix_spawn_file_actions_addopen(&actions_, stream, "/dev/null", O_RDWR, 0);
        posix_spawn_file_actions_addclosefrom_np(&actions_, ChildProgram::kSocket + 1);
    }
    ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
    SpawnActions(const SpawnActions&) = delete;
    SpawnActions& operator=(const SpawnActions&) = delete;

    const posix_spawn_file_actions_t* get() const { return &actions_; }

private:
    posix_spawn_file_actions_t actions_{};
};

class SpawnAttributes {
public:
    SpawnAttributes() {
        // Blocked until the program ignores them, so that they do not end a program that is being started.
        const auto blocked = signals_left_to_server();
        sigset_t all;
        sigfillset(&all);
        posix_spawnattr_init(&attributes_);
        posix_spawnattr_setsigmask(&attributes_, &blocked);
        posix_spawnattr_setsigdefault(&attributes_, &all);
        posix_spawnattr_setpgroup(&attributes_, 0);
        posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    }
    ~SpawnAttributes() { posix_spawnattr_destroy(&attributes_); }
    SpawnAttributes(const SpawnAttributes&) = delete;
    SpawnAttributes& operator=(const SpawnAttributes&) = delete;

    const posix_spawnattr_t* get() const { return &attributes_; }

private:
    posix_spawnattr_t attributes_{};
};

std::vector<char*> environment_to_inherit() {
    std::vector<char*> kept;
    for (char** entry = environ; *entry != nullptr; ++entry) {
        if (!std::string_view(*entry).starts_with("CCDT_")) kept.push_back(*entry);
    }
    kept.push_back(nullptr);
    return kept;
}

tl::unexpected<Error> cannot_start(const std::string& name, int error) {
    return failure(ErrorCode::Internal, "cannot start " + name + ": " + std::strerror(error));
}

/// Opens a descriptor of a process. Uses the system call, because glibc 2.36 does not declare a function for C++.
UniqueFd open_pidfd(pid_t process) {
    return UniqueFd(static_cast<int>(syscall(SYS_pidfd_open, process, 0)));
}

}  // namespace

std::string describe_end(std::optional<int> status) {
    if (!status) return "ended";
    if (WIFEXITED(*status)) return "exited with " + std::to_string(WEXITSTATUS(*status));
    const int number = WTERMSIG(*status);
    return "was killed by signal " + std::to_string(number) + " (" + sigdescr_np(number) + ")";
}

bool is_killed_from_outside(std::optional<int> status) {
    return status && WIFSIGNALED(*status) && WTERMSIG(*status) == SIGKILL;
}

ChildProgram::ChildProgram(pid_t process) : process_(process), pidfd_(open_pidfd(process)) {}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
    : process_(std::exchange(other.process_, 0)), pidfd_(std::move(other.pidfd_)) {}

ChildProgram& ChildProgram::operator=(ChildProgram&& other) noexcept {
    std::swap(process_, other.process_);
    std::swap(pidfd_, other.pidfd_);
    return *this;
}

ChildProgram::~ChildProgram() {
    if (process_ == 0) return;
    kill();
    wait();
}

void ChildProgram::kill() const {
    if (process_ > 0) ::kill(process_, SIGKILL);
}

std::optional<int> ChildProgram::wait() {
    int status = 0;
    pid_t reaped = -1;
    do reaped = waitpid(process_, &status, 0);
    while (reaped < 0 && errno == EINTR);
    process_ = 0;
    return reaped > 0 ? std::optional(status) : std::nullopt;
}

Result<std::string> find_program(const std::string& name) {
    std::error_code error;
    const auto own = std::filesystem::read_symlink("/proc/self/exe", error);
    if (error) return failure(ErrorCode::Internal, "cannot find " + name + ": /proc/self/exe: " + error.message());
    const auto folder = own.parent_path();
    const std::array positions{folder / name, folder.parent_path() / "lib" / "ccdt" / name};
    const auto found = std::ranges::find_if(positions, [&](const auto& position) { return exists(position, error); });
    if (found != positions.end()) return found->string();
    return failure(ErrorCode::Internal, "cannot find " + name + ": neither " + positions.front().string() + " nor " +
                                            positions.back().string() + " exists");
}

Result<ChildProgram> spawn_sibling(const std::string& name, UniqueFd socket, std::vector<std::string> arguments) {
    const auto file = find_program(name);
    if (!file) return tl::unexpected(file.error());
    std::vector<char*> argv{const_cast<char*>(name.c_str())};
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_t process = 0;
    const int failed = posix_spawn(&process, file->c_str(), SpawnActions(socket.get()).get(), SpawnAttributes().get(),
                                   argv.data(), environment_to_inherit().data());
    if (failed != 0) return cannot_start(*file, failed);
    return ChildProgram(process);
}

Backoff::Milliseconds Backoff::after(std::chrono::steady_clock::duration lived) {
    last_ = lived > kLongest ? kFirst : std::clamp(2 * last_, kFirst, kLongest);
    return last_;
}

}  // namespace ccdt::server
