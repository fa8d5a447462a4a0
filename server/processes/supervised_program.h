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

/// A program that the server keeps running: should it end, it is reaped and started again. It is asked once a second
/// whether it is alive (send_probe); it has to answer whatever it does.
///
/// It has a socket that keeps messages apart, over which it first says that it is ready. Until it does, its silence
/// counts as that of one that does not answer. May be used from any thread.
class SupervisedProgram {
public:
    using Clock = std::chrono::steady_clock;
    using Socket = std::shared_ptr<const UniqueFd>;

    /// Starts the program; from any thread.
    using Launch = std::function<Result<ChildProgram>(UniqueFd socket)>;

    /// Takes its first words, which have come; false if they are none.
    using Greet = std::function<bool(int socket)>;

    /// Is told of each end of the program, and when it stops or begins again to answer; in words, from any thread.
    using Tell = std::function<void(const std::string&)>;

    /// Starts the program, whose libraries may take it a while: whoever needs it waits. Errors: Internal.
    /// @param name  for people
    static Result<std::unique_ptr<SupervisedProgram>> start(std::string name, Launch launch, Greet greet, Tell tell);

    /// Ends the program.
    ~SupervisedProgram();

    SupervisedProgram(const SupervisedProgram&) = delete;
    SupervisedProgram& operator=(const SupervisedProgram&) = delete;

    /// Waits until the program is ready for the first time.
    /// Errors (Internal): it ended before that, and is not started again.
    Result<void> wait_until_ready();

    /// The socket to the program, waited for while it is being started again, and for the first time even beyond the
    /// deadline; another one than `lost`, whose program is known to have ended.
    /// @returns  none if there was none until then, or before the stop
    Socket wait_for_socket(const Socket& lost, Clock::time_point deadline, const std::stop_token& stop);

    /// Whether the program is there now, or about to be for the first time.
    bool is_ready() const;

    /// Whether it has answered lately, if it is there.
    bool is_responsive() const { return responsive_; }

    /// Times that it ended, and was or is being started again.
    std::uint64_t restarts() const { return restarts_; }

    /// Times that it stopped answering.
    std::uint64_t silences() const { return silences_; }

private:
    struct Running {
        ChildProgram program;
        Socket socket;
        Clock::time_point started;
    };

    SupervisedProgram(std::string name, Launch launch, Greet greet, Tell tell, UniqueFd closing);

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
    const Tell tell_;
    const UniqueFd closing_;  ///< readable once there is to be no program any more
    std::atomic<std::uint64_t> restarts_ = 0;
    std::atomic<std::uint64_t> silences_ = 0;
    std::atomic<bool> responsive_ = true;

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    Socket socket_;                        ///< none while there is no program; guarded by the mutex
    std::optional<Result<void>> started_;  ///< for the first time, or why not; none yet; guarded by the mutex

    std::jthread watcher_;  ///< last: it uses all the rest
};

}  // namespace ccdt::server
