// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/compute/compute_supervisor.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/compute/compute_protocol.h"
#include "server/decoder/decoder_protocol.h"
#include "server/processes/child_program.h"
#include "server/processes/messages.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Maximum wait for a fork server that is being restarted. Also the maximum wait for a report that a process has ended.
constexpr std::chrono::seconds kPatience{2};

/// The reason why a computation process did not reply.
struct NoReply {
    bool overdue = false;           ///< the computation did not stop in time
    bool unreported = false;        ///< the fork server ended before the process and could not report its end
    std::optional<ChildEnd> death;  ///< report of the end of the process; none: unknown
    /// Whether the process was killed from outside. If its end is unreported, this is likely, as for the fork server.
    bool is_killed() const {
        return unreported || (death && death->fork_error == 0 && is_killed_from_outside(death->status));
    }

    /// Whether a repetition may succeed, because the request is not the cause.
    bool is_temporary() const { return is_killed() || (death && death->fork_error != 0); }
};

std::string describe(const NoReply& none) {
    const std::string process = "the process that computed it ";
    if (none.overdue) return process + "did not stop when it was told to";
    if (!none.death) return process + "ended";
    if (none.death->fork_error != 0)
        return "cannot start a process to compute it: " + std::string(std::strerror(none.death->fork_error));
    return process + describe_end(none.death->status);
}

/// Assembles replies from the received bytes of a channel. Never waits.
class ReplyReader {
public:
    enum class State { Partial, Complete, Ended };

    State read(int channel) {
        if (complete_) *this = {};
        while (!wanted_.empty() || next_piece()) {
            const ssize_t received = recv(channel, wanted_.data(), wanted_.size(), MSG_DONTWAIT);
            if (received < 0 && errno == EINTR) continue;
            if (received < 0 && errno == EAGAIN) return State::Partial;
            if (received <= 0) return State::Ended;
            wanted_ = wanted_.subspan(static_cast<std::size_t>(received));
        }
        return complete_ ? State::Complete : State::Ended;
    }

    const Reply& reply() const { return reply_; }
    std::string take_text(std::size_t index) { return std::move(texts_[index]); }

private:
    /// Begins to receive the next piece of the reply: its head, or one of its texts.
    /// @returns  false if the reply is complete or invalid
    bool next_piece() {
        if (pieces_ == 0) {
            wanted_ = {reinterpret_cast<char*>(&reply_), sizeof(reply_)};
        } else if (pieces_ <= texts_.size()) {
            if (!makes_sense()) return false;
            auto& text = texts_[pieces_ - 1];
            text.resize(reply_.sizes[pieces_ - 1]);
            wanted_ = text;
        } else {
            complete_ = true;
            return false;
        }
        ++pieces_;
        return !wanted_.empty() || next_piece();
    }

    /// Checks the head of a reply. Limits the sizes, so that a damaged process cannot exhaust the server's memory.
    bool makes_sense() const {
        constexpr std::uint64_t kMax = std::uint64_t{4} << 30;
        return reply_.kind <= Reply::Kind::Failure && reply_.code <= static_cast<std::uint32_t>(ErrorCode::Internal) &&
               std::ranges::all_of(reply_.sizes, [](std::uint64_t size) { return size <= kMax; });
    }

    Reply reply_;
    std::array<std::string, Reply::kTexts> texts_;
    std::span<char> wanted_;  ///< missing bytes of the current piece
    std::size_t pieces_ = 0;  ///< number of pieces begun: the head, then the texts
    bool complete_ = false;
};

}  // namespace

/// The server's sockets to a computation process. The process ends when the server closes them.
struct ComputeSupervisor::Process {
    UniqueFd channel;
    UniqueFd events;
    int nice = 0;          ///< nice value at the start
    bool yielded = false;  ///< the nice value is higher now

    /// Whether an idle process still runs. Its channel becomes readable only when the process ends.
    bool is_there() const {
        pollfd polled{channel.get(), POLLIN, 0};
        return poll(&polled, 1, 0) == 0;
    }
};

/// Sends one request to a computation process, and receives the replies until the computation has ended.
class ComputeSupervisor::Conversation {
public:
    using Outcome = tl::expected<Result<api::Answer>, NoReply>;

    Conversation(ComputeSupervisor& supervisor, Process& process, const Delivery& delivery, const Control& control,
                 api::Timings& timings)
        : supervisor_(supervisor),
          process_(process),
          delivery_(delivery),
          control_(control),
          timings_(timings),
          stopped_(eventfd(0, EFD_CLOEXEC)) {}

    /// Whether the head of a large answer has arrived.
    bool has_begun() const { return head_.has_value(); }

    /// Whether the receiver of the answer has failed. The process may then still be computing.
    bool is_abandoned() const { return abandoned_; }

    Outcome run(Call call, const ComputeRequest& request) {
        const std::array<std::string_view, Call::kTexts> texts = {request.path, request.query, request.content_type,
                                                                  request.accept, request.body};
        for (std::size_t i = 0; i < texts.size(); ++i) call.sizes[i] = texts[i].size();
        if (!send_texts(process_.channel.get(), {text_of(call), texts[0], texts[1], texts[2], texts[3], texts[4]}))
            return lost();
        const auto wake = [this] { eventfd_write(stopped_.get(), 1); };
        const std::stop_callback on_stop(control_.stop, wake);
        const std::stop_callback on_leaving(delivery_.unwanted, wake);
        const auto& options = supervisor_.options_;
        if (process_.nice < options.nice_of_long) yield_at_ = Clock::now() + options.to_yield;
        while (true) {
            if (yield_at_ && *yield_at_ <= Clock::now()) yield();
            std::array<pollfd, 3> polled = {
                {{process_.channel.get(), POLLIN, 0}, {process_.events.get(), POLLIN, 0}, {stopped_.get(), POLLIN, 0}}};
            if (poll(polled.data(), polled.size(), milliseconds_until(yield_at_ ? yield_at_ : end_at_)) == 0) {
                if (yield_at_) continue;
                end();
                return tl::unexpected(NoReply{.overdue = true, .death = {}});
            }
            const auto& [channel, events, stopped] = polled;
            if (channel.revents != 0) {
                if (auto outcome = listen()) return *std::move(outcome);
            }
            if (events.revents != 0) take_event();
            if (stopped.revents != 0) pass_on_stop(call);
        }
    }

    /// Ends the process, and waits for its end, which frees its memory.
    void end() {
        process_.channel.reset();
        wait_for_death();
    }

private:
    /// Handles all replies that have arrived.
    /// @returns  the outcome, if the computation has ended
    std::optional<Outcome> listen() {
        while (true) {
            const auto state = reader_.read(process_.channel.get());
            if (state == ReplyReader::State::Partial) return std::nullopt;
            if (state == ReplyReader::State::Ended) return lost();
            const Reply& reply = reader_.reply();
            switch (reply.kind) {
                case Reply::Kind::Step:
                    if (control_.progress) control_.progress(reply.progress);
                    break;
                case Reply::Kind::Head:
                case Reply::Kind::Piece:
                    if (auto taken = reply.kind == Reply::Kind::Head ? begin(reply) : take_piece(); !taken) {
                        abandoned_ = true;
                        return Result<api::Answer>(tl::unexpected(std::move(taken.error())));
                    }
                    break;
                case Reply::Kind::Answer:
                case Reply::Kind::Failure:
                    return finish(reply);
            }
        }
    }

    Result<void> begin(const Reply& reply) {
        timings_ = reply.timings;
        head_ = answer_of(reply);
        return delivery_.sink == nullptr ? Result<void>() : delivery_.sink->begin(*head_);
    }

    Result<void> take_piece() {
        if (!head_) return failure(ErrorCode::Internal, "a piece of a body arrived before its head");
        const std::string piece = reader_.take_text(2);
        if (delivery_.sink != nullptr) return delivery_.sink->write(piece);
        head_->body += piece;
        return {};
    }

    Outcome finish(const Reply& reply) {
        timings_ = reply.timings;
        supervisor_.decoder_deaths_ += reply.decoder_deaths;
        if (reply.kind == Reply::Kind::Failure)
            return failure(static_cast<ErrorCode>(reply.code), reader_.take_text(0), reader_.take_text(1));
        api::Answer answer = answer_of(reply);
        if (!answer.streamed) return answer;
        if (!head_) return failure(ErrorCode::Internal, "the body of the answer did not arrive");
        answer.coding = head_->coding;
        answer.body = std::move(head_->body);
        answer.streamed = delivery_.sink != nullptr;
        return answer;
    }

    api::Answer answer_of(const Reply& reply) {
        api::Answer answer;
        answer.media_type = reader_.take_text(0);
        answer.coding = reader_.take_text(1);
        answer.body = reader_.take_text(2);
        answer.repaired = reader_.take_text(3);
        answer.warnings = reader_.take_text(4);
        answer.sites = reply.sites;
        answer.pixels = reply.pixels;
        answer.partial = reply.partial != 0;
        answer.repeats = reply.repeats != 0;
        answer.streamed = reply.streamed != 0;
        if (reply.plot_seconds >= 0) answer.plot = api::PlotSize{reply.plot_seconds};
        if (reply.radius > 0) answer.dots = api::DotSize{reply.radius, reply.tone};
        return answer;
    }

    /// Tells the process to stop, and sets the time at which a process that has not stopped is ended. The process keeps
    /// its priority, with which it ends soon even on a busy machine.
    void pass_on_stop(const Call& call) {
        eventfd_t discarded = 0;
        eventfd_read(stopped_.get(), &discarded);
        yield_at_.reset();
        const Call stop{.kind = Call::Kind::Stop, .number = call.number, .limits = {}, .sizes = {}};
        if (!end_at_) static_cast<void>(send_texts(process_.channel.get(), {text_of(stop)}));
        const auto& options = supervisor_.options_;
        const Clock::duration longest =
            delivery_.unwanted.stop_requested() ? options.to_leave : Clock::duration(options.to_stop);
        end_at_ = std::min(end_at_.value_or(Clock::time_point::max()), Clock::now() + longest);
    }

    /// Lowers the priority of the process.
    void yield() {
        yield_at_.reset();
        const Call lower{
            .kind = Call::Kind::Yield, .nice = supervisor_.options_.nice_of_long, .limits = {}, .sizes = {}};
        process_.yielded = send_texts(process_.channel.get(), {text_of(lower)});
    }

    /// Receives an event: an order, which is passed to the decoder, the report that the process has ended, or the end
    /// of the socket, which closes when both the process and the fork server that forked it have ended.
    void take_event() {
        Order order;
        Order::Files files;
        const std::size_t size = receive_message(process_.events.get(), writable_bytes_of(order.text), files);
        if (size == sizeof(ChildEnd)) {
            std::memcpy(static_cast<void*>(&death_.emplace()), &order.text, sizeof(ChildEnd));
        }
        unreported_ = size == 0 && !death_;
        if (size != sizeof(order.text)) return;
        order.take(std::move(files));
        supervisor_.relay_(order, control_.stop);
    }

    /// Waits for the fork server's report that the process has ended, for at most kPatience.
    void wait_for_death() {
        const auto until = Clock::now() + kPatience;
        pollfd events{process_.events.get(), POLLIN, 0};
        while (!death_ && !unreported_ && poll(&events, 1, milliseconds_until(until)) > 0) take_event();
    }

    tl::unexpected<NoReply> lost() {
        wait_for_death();
        return tl::unexpected(NoReply{.unreported = unreported_, .death = death_});
    }

    ComputeSupervisor& supervisor_;
    Process& process_;
    const Delivery& delivery_;
    const Control& control_;
    api::Timings& timings_;
    const UniqueFd stopped_;  ///< readable once a stop was requested
    ReplyReader reader_;
    std::optional<api::Answer> head_;  ///< head of an answer sent in pieces; also its body if there is no sink
    bool abandoned_ = false;
    std::optional<Clock::time_point> end_at_;
    std::optional<Clock::time_point> yield_at_;  ///< none: the priority stays as it is
    bool unreported_ = false;                    ///< see NoReply
    std::optional<ChildEnd> death_;
};

Result<std::unique_ptr<ComputeSupervisor>> ComputeSupervisor::start(SupervisedProgram::Launch launch,
                                                                    const Options& options, Relay relay,
                                                                    SupervisedProgram::Report report) {
    const auto greet = [](int socket) {
        std::byte ready{};
        return receive_message(socket, {&ready, 1}) == 1;
    };
    auto threads = SharedNumber::create(1);
    if (!threads) return tl::unexpected(std::move(threads.error()));
    auto fork_server = SupervisedProgram::start("worker", std::move(launch), greet, std::move(report));
    if (!fork_server) return tl::unexpected(std::move(fork_server.error()));
    return std::unique_ptr<ComputeSupervisor>(
        new ComputeSupervisor(*std::move(fork_server), *std::move(threads), options, std::move(relay)));
}

ComputeSupervisor::ComputeSupervisor(std::unique_ptr<SupervisedProgram> fork_server, SharedNumber threads,
                                     const Options& options, Relay relay)
    : options_(options), relay_(std::move(relay)), threads_(std::move(threads)), fork_server_(std::move(fork_server)) {}

ComputeSupervisor::~ComputeSupervisor() = default;

ComputeSupervisor::Counts ComputeSupervisor::counts() const {
    return {crashes_, overdue_, fork_server_->restarts(), fork_server_->silences(), decoder_deaths_};
}

Result<api::Answer> ComputeSupervisor::compute(const ComputeRequest& request, const Delivery& delivery,
                                               const Control& control, api::Timings& timings) {
    const Call call{
        .compressed = delivery.compressed ? 1U : 0U, .number = ++computations_, .limits = options_.limits, .sizes = {}};
    const int nice = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
    for (bool again = false;; again = true) {
        auto process = take_process(nice, control.stop);
        if (!process) return tl::unexpected(std::move(process.error()));
        Conversation conversation(*this, *process, delivery, control, timings);
        auto outcome = conversation.run(call, request);
        if (outcome) {
            if (conversation.is_abandoned())
                conversation.end();
            else
                give_back(*std::move(process));
            return *std::move(outcome);
        }
        const bool was_left = outcome.error().overdue && delivery.unwanted.stop_requested();
        if (!was_left) ++(outcome.error().overdue ? overdue_ : crashes_);
        if (was_left || control.stop.stop_requested()) return failure(ErrorCode::Stopped, describe(outcome.error()));
        const bool is_streaming = conversation.has_begun() && delivery.sink != nullptr;
        if (again || is_streaming || !outcome.error().is_killed())
            return failure(outcome.error().is_temporary() ? ErrorCode::Unavailable : ErrorCode::Internal,
                           describe(outcome.error()));
    }
}

Result<ComputeSupervisor::Process> ComputeSupervisor::take_process(int nice, const std::stop_token& stop) {
    while (true) {
        std::optional<Process> idle;
        {
            const std::lock_guard lock(mutex_);
            auto& processes = idle_[nice];
            if (processes.empty()) break;
            idle = std::move(processes.back());
            processes.pop_back();
        }
        if (idle->is_there()) return *std::move(idle);
    }
    return make_process(nice, stop);
}

Result<ComputeSupervisor::Process> ComputeSupervisor::make_process(int nice, const std::stop_token& stop) {
    const auto until = Clock::now() + kPatience;
    for (SupervisedProgram::Socket lost;;) {
        const auto fork_server = fork_server_->wait_for_socket(lost, until, stop);
        if (fork_server == nullptr)
            return failure(ErrorCode::Unavailable,
                           "cannot start a process to compute it: the fork server is not running");
        auto channel = make_sockets(SOCK_STREAM);
        auto events = make_sockets(SOCK_SEQPACKET);
        if (!channel || !events)
            return failure(ErrorCode::Unavailable,
                           std::string("cannot create sockets for a process: ") + std::strerror(errno));
        const timeval longest{options_.to_stop.count(), 0};
        setsockopt(channel->ours.get(), SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof(longest));
        const ForkOrder order{nice};
        const std::array<int, 3> theirs = {channel->theirs.get(), events->theirs.get(), threads_.file().get()};
        if (send_message(fork_server->get(), bytes_of(order), theirs))
            return Process{std::move(channel->ours), std::move(events->ours), nice};
        lost = fork_server;
    }
}

/// Keeps a process for the next computation, unless its priority was lowered, which cannot be undone.
void ComputeSupervisor::give_back(Process process) {
    if (process.yielded) return;
    const std::lock_guard lock(mutex_);
    idle_[process.nice].push_back(std::move(process));
}

}  // namespace ccdt::server
