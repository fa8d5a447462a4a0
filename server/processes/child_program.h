// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "core/base/result.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A child process. The destructor kills and reaps the process.
class ChildProgram {
public:
    /// Descriptor number that the socket to this process has in a spawned program.
    static constexpr int kSocket = 3;

    /// Takes ownership of a child. Nothing else may reap the child.
    explicit ChildProgram(pid_t process);
    ~ChildProgram();
    ChildProgram(ChildProgram&& other) noexcept;
    ChildProgram& operator=(ChildProgram&& other) noexcept;

    pid_t id() const { return process_; }

    /// Returns a descriptor for poll() that is readable once the child has ended; -1 if unavailable.
    int ended() const { return pidfd_.get(); }

    /// Sends SIGKILL. Has no effect after the child has ended.
    void kill() const;

    /// Waits for the end of the child, and reaps it. Must be called at most once.
    /// @returns  status of waitpid(); none if the kernel has reaped the child, because SIGCHLD is ignored
    std::optional<int> wait();

private:
    pid_t process_ = 0;  ///< 0: moved from or reaped
    UniqueFd pidfd_;
};

/// Describes the end of a process, such as "exited with 1" or "was killed by signal 9 (Killed)".
/// @param status  as set by waitpid(); none: unknown
std::string describe_end(std::optional<int> status);

/// Whether a process was killed from outside: by the system for lack of memory, or by an operator. Faults of a process
/// itself end it by other signals.
/// @param status  as set by waitpid(); none: unknown
bool is_killed_from_outside(std::optional<int> status);

/// Finds a program that belongs to the calling program: beside it, as in a build tree or an image, or in ../lib/ccdt,
/// as in an installed tree.
///
/// @param name  file name of the program
/// @returns     absolute path of the file, which need not be executable
/// Error (Internal): the file is in neither folder. The message names both.
Result<std::string> find_program(const std::string& name);

/// Starts a program that find_program() finds. A new process group shields it from terminal signals.
///
/// The child inherits `socket` as ChildProgram::kSocket, and standard error. Its other standard streams are /dev/null.
/// Signals have the default actions in the child. The environment of the child lacks the variables CCDT_*, which may
/// contain secrets. The function may be called from any thread.
/// @param name       file name of the program
/// @param socket     closed in the calling process
/// @param arguments  without the program's name
/// Errors: Internal.
Result<ChildProgram> spawn_sibling(const std::string& name, UniqueFd socket, std::vector<std::string> arguments = {});

/// Computes exponentially growing pauses between restarts of a program.
class Backoff {
public:
    using Milliseconds = std::chrono::milliseconds;

    static constexpr Milliseconds kFirst{10};
    static constexpr Milliseconds kLongest{1000};

    /// @param lived  time between the start and the end of the program
    /// @returns      kFirst if `lived` exceeds kLongest, otherwise twice the last pause, at most kLongest
    Milliseconds after(std::chrono::steady_clock::duration lived);

private:
    Milliseconds last_{0};
};

}  // namespace ccdt::server
