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

/// Computes answers in processes that may crash: each costs its own request only.
///
/// A fork server, a program of its own, makes a process whenever none is idle; there are as many as ever computed at
/// the same time. A process that is killed from outside, as by a system without memory, has done nothing wrong: its
/// computation is begun again, once. Members may be called from any thread.
class ComputeBox {
public:
    /// Hands a process' order on to the decoder; its outcome goes to the process itself.
    using Relay = std::function<void(const Order& order, const std::stop_token& stop)>;

    struct Options {
        api::Limits limits;
        std::chrono::seconds to_stop{5};  ///< what a computation may take from its stop to its end

        /// The same where nobody wants the answer any more. A process takes about a millisecond to be made, and 3 GB a
        /// quarter of a second to be given back.
        std::chrono::milliseconds to_leave{50};
    };

    /// Starts the fork server. Errors: Internal.
    static Result<std::unique_ptr<ComputeBox>> start(SupervisedProgram::Launch launch, const Options& options,
                                                     Relay relay, SupervisedProgram::Tell tell);

    ~ComputeBox();

    ComputeBox(const ComputeBox&) = delete;
    ComputeBox& operator=(const ComputeBox&) = delete;

    /// Waits until processes can be made for the first time. Errors: Internal; none are ever made then.
    Result<void> wait_until_ready() { return fork_server_->wait_until_ready(); }

    /// Computes an answer: see Compute. The process gives way to others as much as the calling thread does. A
    /// computation that does not stop in time is ended with its process; that counts as overdue if somebody waits.
    Result<api::Answer> compute(const ComputeRequest& request, const Delivery& delivery, const Control& control,
                                api::Timings& timings);

    /// Has each computation use so many threads, of which one is its process' own, from its next step on.
    void lend(std::size_t threads) { threads_.store(static_cast<std::uint32_t>(threads)); }

    /// Threads that each computation may have now: 1 at first.
    std::size_t lent() const { return threads_.load(); }

    /// Whether processes can be made now, or are about to be for the first time.
    bool is_ready() const { return fork_server_->is_ready(); }

    /// Whether the fork server has answered lately.
    bool is_responsive() const { return fork_server_->is_responsive(); }

    struct Counts {
        std::uint64_t crashes = 0;         ///< processes that ended by themselves while they computed
        std::uint64_t overdue = 0;         ///< processes ended since they did not stop at a deadline
        std::uint64_t restarts = 0;        ///< of the fork server
        std::uint64_t silences = 0;        ///< times that the fork server stopped answering
        std::uint64_t decoder_deaths = 0;  ///< pictures whose decoder crashed, passed a limit or gave nonsense
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
    SharedNumber threads_;  ///< that each computation may have

    std::mutex mutex_;
    std::map<int, std::vector<Process>> idle_;  ///< by how much they give way; guarded by the mutex

    const std::unique_ptr<SupervisedProgram> fork_server_;
};

}  // namespace ccdt::server
