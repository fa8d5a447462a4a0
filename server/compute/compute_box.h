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
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/processes/shared_number.h"
#include "server/processes/supervised_program.h"
#include "server/processes/unique_fd.h"
#include "server/work/computation.h"

namespace ccdt::server {

struct Order;

/// Computes answers in separate processes, so that a crash costs only the request that caused it.
///
/// Processes are kept for later computations. If a computation begins and no process with the required nice value is
/// idle, the fork server, which is a separate program, forks one. If a process is killed from outside, for example
/// because the machine ran out of memory, its computation is started again, once. Thread-safe.
class ComputeBox {
public:
    /// Passes an order from a computation process on to the decoder, which sends the result directly to the computation
    /// process.
    using Relay = std::function<void(const Order& order, const std::stop_token& stop)>;

    struct Options {
        api::Limits limits;
        std::chrono::seconds to_stop{5};  ///< time limit from a request to stop until the computation ends

        /// The same time limit if nobody waits for the answer any more. The limit is short, because ending the process
        /// costs little: another process starts in about a millisecond, and even freeing 3 GB takes only a quarter of a
        /// second.
        std::chrono::milliseconds to_leave{50};
    };

    /// Starts the fork server. Errors: Internal.
    static Result<std::unique_ptr<ComputeBox>> start(SupervisedProgram::Launch launch, const Options& options,
                                                     Relay relay, SupervisedProgram::Report report);

    ~ComputeBox();

    ComputeBox(const ComputeBox&) = delete;
    ComputeBox& operator=(const ComputeBox&) = delete;

    /// Waits until the fork server is ready for the first time. Errors: as SupervisedProgram::wait_until_ready.
    Result<void> wait_until_ready(const std::stop_token& stop = {}) { return fork_server_->wait_until_ready(stop); }

    /// Computes an answer: see Compute. The process has the nice value of the calling thread. If the computation does
    /// not stop in time, its process is ended. If somebody still waits for the answer, the computation is counted as
    /// overdue.
    Result<api::Answer> compute(const ComputeRequest& request, const Delivery& delivery, const Control& control,
                                api::Timings& timings);

    /// Sets the number of threads that each computation may use, including the main thread of its process. A running
    /// computation applies the new number from its next step on.
    void lend(std::size_t threads) { threads_.store(static_cast<std::uint32_t>(threads)); }

    /// Number of threads that each computation may use now; initially 1.
    std::size_t lent() const { return threads_.load(); }

    /// Whether the fork server can fork processes now, or is starting for the first time.
    bool is_ready() const { return fork_server_->is_ready(); }

    /// Whether the fork server has replied recently.
    bool is_responsive() const { return fork_server_->is_responsive(); }

    struct Counts {
        std::uint64_t crashes = 0;   ///< processes that crashed while they computed
        std::uint64_t overdue = 0;   ///< processes ended because they did not stop at a deadline
        std::uint64_t restarts = 0;  ///< restarts of the fork server
        std::uint64_t silences = 0;  ///< times that the fork server stopped replying
        std::uint64_t decoder_deaths =
            0;  ///< pictures whose decoder crashed, exceeded a limit or wrote an invalid reply
    };
    Counts counts() const;

private:
    struct Process;
    class Conversation;

    ComputeBox(std::unique_ptr<SupervisedProgram> fork_server, SharedNumber threads, const Options& options,
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
    SharedNumber threads_;  ///< limit of each computation

    std::mutex mutex_;
    std::map<int, std::vector<Process>> idle_;  ///< idle processes by nice value; guarded by the mutex

    const std::unique_ptr<SupervisedProgram> fork_server_;
};

}  // namespace ccdt::server
