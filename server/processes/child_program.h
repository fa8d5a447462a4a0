#pragma once

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

#include "core/result.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A child process of this one: ended and reaped with its handle.
class ChildProgram {
public:
    /// Descriptor at which a program that was spawned finds its socket.
    static constexpr int kSocket = 3;

    /// Takes over a child that nobody else reaps.
    explicit ChildProgram(pid_t process);
    ~ChildProgram();
    ChildProgram(ChildProgram&& other) noexcept;
    ChildProgram& operator=(ChildProgram&& other) noexcept;

    pid_t id() const { return process_; }

    /// A descriptor to poll, readable once the child has ended; -1 if there is none, and `wait` has to do.
    int ended() const { return pidfd_.get(); }

    /// Sends SIGKILL; no harm after its end.
    void kill() const;

    /// Waits for its end and reaps it; to be called once.
    /// @returns  as describe_end
    std::string wait();

private:
    pid_t process_ = 0;  ///< 0 once it is reaped
    UniqueFd pidfd_;
};

/// Describes how a process ended, after its name, from what waitpid tells: "exited with 1", "was killed by signal 9
/// (Killed)".
std::string describe_end(int status);

/// Blocks SIGCHLD, and tells of it instead: for a process of one thread that forks.
/// @returns  readable, without waiting, once a child has ended; none if the system has no more
UniqueFd watch_children();

/// Starts a program whose file lies beside this one's, in a process group of its own: signals of a terminal are this
/// program's to act on.
///
/// May be called from any thread. The child inherits `socket` as ChildProgram::kSocket and the standard error; its
/// other standard streams are /dev/null, signals are as by default, and of the environment it lacks CCDT_*, among
/// which there may be secrets.
/// @param name       of the file
/// @param socket     closed here
/// @param arguments  after the name
/// Errors: Internal.
Result<ChildProgram> spawn_sibling(const std::string& name, UniqueFd socket, std::vector<std::string> arguments = {});

/// Pauses before a program that ended is started again: no tight loop if each end comes soon.
class Backoff {
public:
    using Milliseconds = std::chrono::milliseconds;

    static constexpr Milliseconds kFirst{10};
    static constexpr Milliseconds kLongest{1000};

    /// @param lived  since the program was started
    /// @returns      kFirst; twice the last one, up to kLongest, if the program lived no longer than that
    Milliseconds after(std::chrono::steady_clock::duration lived);

private:
    Milliseconds last_{0};
};

}  // namespace ccdt::server
