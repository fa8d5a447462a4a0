// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/base/result.h"
#include "server/processes/child_program.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A program that the server keeps running. If the program ends, it is reaped and restarted. Once a second, the server
/// sends a probe (send_probe), to which the program must reply even while it is busy.
///
/// A socket that preserves message boundaries connects the server and the program. The program's first message reports
/// that it is ready. If this message or a reply is late, the program counts as not responding. Thread-safe.
class SupervisedProgram {
public:
    using Clock = std::chrono::steady_clock;
    using Socket = std::shared_ptr<const UniqueFd>;

    /// Starts the program with its end of the socket. Called from any thread.
    using Launch = std::function<Result<ChildProgram>(UniqueFd socket)>;

    /// Reads the program's first message, which has arrived. Returns false if the message is invalid.
    using Greet = std::function<bool(int socket)>;

    /// Receives a text for the log when the program ends, stops responding or responds again. Called from any thread.
    using Report = std::function<void(const std::string&)>;

    /// Starts the program, and does not wait until it is ready. Error: Internal.
    /// @param name  name of the program for messages
    static Result<std::unique_ptr<SupervisedProgram>> start(std::string name, Launch launch, Greet greet,
                                                            Report report);

    /// Ends the program.
    ~SupervisedProgram();

    SupervisedProgram(const SupervisedProgram&) = delete;
    SupervisedProgram& operator=(const SupervisedProgram&) = delete;

    /// Waits until the program is ready for the first time. A program that is killed from outside before it is ready is
    /// started again, for up to 30 s.
    /// Errors: Internal if the program ended otherwise; Unavailable if it was killed for too long; Stopped.
    Result<void> wait_until_ready(const std::stop_token& stop = {});

    /// Returns the socket to the program. Waits for a restart of the program until the deadline, and for its first
    /// start without a time limit.
    /// @param lost  socket to which sending failed, because its program has ended; is not returned again; null: none
    /// @returns     null if no program was ready by the deadline, or if a stop was requested
    Socket wait_for_socket(const Socket& lost, Clock::time_point deadline, const std::stop_token& stop);

    /// Whether the program is ready now, or starting for the first time.
    bool is_ready() const;

    /// Whether the program has replied recently. Also true while the program does not run.
    bool is_responsive() const { return responsive_; }

    /// Returns the number of restarts of the program, including one in progress.
    std::uint64_t restarts() const { return restarts_; }

    /// Returns the number of times that the program stopped replying.
    std::uint64_t silences() const { return silences_; }

private:
    struct Running {
        ChildProgram program;
        Socket socket;
        Clock::time_point started;
    };

    SupervisedProgram(std::string name, Launch launch, Greet greet, Report report, UniqueFd closing);

    Result<Running> launch() const;
    Result<void> await_first_start(Running& running);
    Result<void> await(Running& running);
    void watch(Running running);
    bool attend(const Running& running);
    void set_responsive(bool responsive);
    std::optional<Running> launch_again(Backoff& backoff, Clock::duration lived);
    void set_socket(Socket socket);
    void end_start(Result<void> started);

    const std::string name_;
    const Launch launch_;
    const Greet greet_;
    const Report report_;
    const UniqueFd closing_;  ///< readable when the program must not be restarted any more
    std::atomic<std::uint64_t> restarts_ = 0;
    std::atomic<std::uint64_t> silences_ = 0;
    std::atomic<bool> responsive_ = true;

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    Socket socket_;                        ///< null while the program does not run; guarded by the mutex
    std::optional<Result<void>> started_;  ///< result of the first start; none while it lasts; guarded by the mutex

    std::jthread watcher_;  ///< last, because it uses all other members
};

}  // namespace ccdt::server
