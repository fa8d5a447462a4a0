// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "server/processes/shared_number.h"
#include "server/processes/supervised_program.h"
#include "server/processes/unique_fd.h"
#include "server/requests/compute.h"

namespace ccdt::server {

struct Order;

/// Computes answers in separate processes, so that a crash affects only the request that caused it.
///
/// Idle processes are reused. If none has the nice value that a computation needs, the fork server, a separate program,
/// forks one. If a process is killed from outside, for example because the machine ran out of memory, its computation
/// is repeated once. Thread-safe.
class ComputeSupervisor {
public:
    /// Forwards an order to the decoder. A computation process gives such an order to have a file decoded. The decoder
    /// sends the result directly to this process.
    using Relay = std::function<void(const Order& order, const std::stop_token& stop)>;

    struct Options {
        api::Limits limits;
        std::chrono::seconds to_stop{5};  ///< time in which a computation must stop; afterwards its process is ended

        /// The same limit if nobody waits for the answer. It is short, because ending a process costs little: a new one
        /// starts in about a millisecond, and the system frees 3 GB in 0.25 s.
        std::chrono::milliseconds to_leave{50};

        /// Time after which the nice value of a process rises to `nice_of_long`, if it is lower.
        std::chrono::milliseconds to_yield{50};
        int nice_of_long = 0;
    };

    /// Starts the fork server. Error: Internal.
    static Result<std::unique_ptr<ComputeSupervisor>> start(SupervisedProgram::Launch launch, const Options& options,
                                                            Relay relay, SupervisedProgram::Report report);

    ~ComputeSupervisor();

    ComputeSupervisor(const ComputeSupervisor&) = delete;
    ComputeSupervisor& operator=(const ComputeSupervisor&) = delete;

    /// Waits until the fork server is ready for the first time. Errors: as SupervisedProgram::wait_until_ready.
    Result<void> wait_until_ready(const std::stop_token& stop = {}) { return fork_server_->wait_until_ready(stop); }

    /// Computes an answer, as specified for Compute. The process has the nice value of the calling thread, until the
    /// computation has taken `to_yield`. A process that does not stop in time is ended. If a client still waits for the
    /// answer, the process is counted as overdue.
    Result<api::Answer> compute(const ComputeRequest& request, const Delivery& delivery, const Control& control,
                                api::Timings& timings);

    /// Sets the number of threads that each computation may use, including the main thread of its process. Running
    /// computations apply the new number at their next parallel step.
    void lend(std::size_t threads) { threads_.store(static_cast<std::uint32_t>(threads)); }

    /// Returns the number of threads that each computation may use; initially 1.
    std::size_t lent() const { return threads_.load(); }

    /// Whether the fork server can fork processes now, or is starting for the first time.
    bool is_ready() const { return fork_server_->is_ready(); }

    /// Whether the fork server has replied recently.
    bool is_responsive() const { return fork_server_->is_responsive(); }

    struct Counts {
        std::uint64_t crashes = 0;         ///< processes that crashed while they computed
        std::uint64_t overdue = 0;         ///< processes ended because they did not stop in time
        std::uint64_t restarts = 0;        ///< restarts of the fork server
        std::uint64_t silences = 0;        ///< number of times that the fork server stopped replying
        std::uint64_t decoder_deaths = 0;  ///< decoders that crashed, exceeded a limit or sent an invalid reply
    };
    Counts counts() const;

private:
    struct Process;
    class Conversation;

    ComputeSupervisor(std::unique_ptr<SupervisedProgram> fork_server, SharedNumber threads, const Options& options,
                      Relay relay);

    Result<Process> take_process(int nice, const std::stop_token& stop);
    Result<Process> make_process(int nice, const std::stop_token& stop);
    void give_back(Process process);

    const Options options_;
    const Relay relay_;
    std::atomic<std::uint64_t> crashes_ = 0;
    std::atomic<std::uint64_t> overdue_ = 0;
    std::atomic<std::uint64_t> decoder_deaths_ = 0;
    std::atomic<std::uint64_t> computations_ = 0;
    SharedNumber threads_;  ///< number of threads that each computation may use

    std::mutex mutex_;
    std::map<int, std::vector<Process>> idle_;  ///< idle processes by nice value; guarded by the mutex

    const std::unique_ptr<SupervisedProgram> fork_server_;
};

}  // namespace ccdt::server
