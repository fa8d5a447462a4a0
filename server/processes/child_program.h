// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

#include "core/result.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A child process. The destructor kills and reaps it.
class ChildProgram {
public:
    /// Descriptor of the socket in a spawned program.
    static constexpr int kSocket = 3;

    /// Takes ownership of a child that nothing else reaps.
    explicit ChildProgram(pid_t process);
    ~ChildProgram();
    ChildProgram(ChildProgram&& other) noexcept;
    ChildProgram& operator=(ChildProgram&& other) noexcept;

    pid_t id() const { return process_; }

    /// A descriptor for poll(), readable once the child has ended; -1 if it is unavailable and `wait` must be used.
    int ended() const { return pidfd_.get(); }

    /// Sends SIGKILL. Has no effect after the child has ended.
    void kill() const;

    /// Waits for the end of the child and reaps it. Must be called at most once.
    /// @returns  the text of describe_end
    std::string wait();

private:
    pid_t process_ = 0;  ///< 0 once it was reaped
    UniqueFd pidfd_;
};

/// Describes how a process ended, from the status of waitpid, as a predicate: "exited with 1", "was killed by signal 9
/// (Killed)".
std::string describe_end(int status);

/// Starts a program from this program's folder, in a process group of its own, so that terminal signals reach this
/// program only.
///
/// May be called from any thread. The child inherits `socket` as ChildProgram::kSocket, and standard error. Its other
/// standard streams are /dev/null, and its signal handling is the default. Its environment lacks the variables CCDT_*,
/// which may contain secrets.
/// @param name       name of the file
/// @param socket     is closed in this process
/// @param arguments  without the program's name
/// Errors: Internal.
Result<ChildProgram> spawn_sibling(const std::string& name, UniqueFd socket, std::vector<std::string> arguments = {});

/// Exponential pauses between restarts of a program, so that repeated failures do not cause a tight loop.
class Backoff {
public:
    using Milliseconds = std::chrono::milliseconds;

    static constexpr Milliseconds kFirst{10};
    static constexpr Milliseconds kLongest{1000};

    /// @param lived  time since the program was started
    /// @returns      kFirst if the program lived longer than kLongest, otherwise twice the last pause, at most kLongest
    Milliseconds after(std::chrono::steady_clock::duration lived);

private:
    Milliseconds last_{0};
};

}  // namespace ccdt::server
