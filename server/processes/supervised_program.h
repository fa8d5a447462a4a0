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

#include "core/result.h"
#include "server/processes/child_program.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A program that the server keeps running: if the program ends, it is reaped and restarted. Once a second, the server
/// asks the program whether it is alive (send_probe). The program must reply even while it is busy.
///
/// The program has a socket that preserves message boundaries. Its first message reports that it is ready. If this
/// message is late, the program counts as not responding, like one that does not reply to a probe. Thread-safe.
class SupervisedProgram {
public:
    using Clock = std::chrono::steady_clock;
    using Socket = std::shared_ptr<const UniqueFd>;

    /// Starts the program. Called from any thread.
    using Launch = std::function<Result<ChildProgram>(UniqueFd socket)>;

    /// Reads the program's first message, which has arrived; returns false if it is invalid.
    using Greet = std::function<bool(int socket)>;

    /// Receives a message when the program ends, stops responding or responds again. Called from any thread.
    using Report = std::function<void(const std::string&)>;

    /// Starts the program, which may need some time to load its libraries. Callers that need the program wait. Errors:
    /// Internal.
    /// @param name  name for messages
    static Result<std::unique_ptr<SupervisedProgram>> start(std::string name, Launch launch, Greet greet,
                                                            Report report);

    /// Ends the program.
    ~SupervisedProgram();

    SupervisedProgram(const SupervisedProgram&) = delete;
    SupervisedProgram& operator=(const SupervisedProgram&) = delete;

    /// Waits until the program is ready for the first time.
    /// Errors: Internal if the program ended before it was ready, in which case it is not restarted; Stopped.
    Result<void> wait_until_ready(const std::stop_token& stop = {});

    /// Returns the socket to the program, and waits while the program is restarted. The deadline does not limit the
    /// wait for the first start.
    /// @param lost  socket that must not be returned, because its program has ended; null: none
    /// @returns     none if there was no program by the deadline, or if a stop was requested
    Socket wait_for_socket(const Socket& lost, Clock::time_point deadline, const std::stop_token& stop);

    /// Whether the program is ready now, or starting for the first time.
    bool is_ready() const;

    /// Whether the program, if it runs, has replied recently.
    bool is_responsive() const { return responsive_; }

    /// Number of times that the program ended and was or is being restarted.
    std::uint64_t restarts() const { return restarts_; }

    /// Number of times that the program stopped replying.
    std::uint64_t silences() const { return silences_; }

private:
    struct Running {
        ChildProgram program;
        Socket socket;
        Clock::time_point started;
    };

    SupervisedProgram(std::string name, Launch launch, Greet greet, Report report, UniqueFd closing);

    Result<Running> launch() const;
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
    const UniqueFd closing_;  ///< readable once the program must not be restarted any more
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
