#include "server/decoder/decoder_box.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>

#include "api/image/image_header.h"
#include "server/decoder/decoder_protocol.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Why there is no reply.
struct NoReply {
    enum class Reason { Died, TooSlow, Stopped, NotStarted, OrderLost, HelperGone };
    Reason reason = Reason::OrderLost;
    int error = 0;  ///< errno of NotStarted
};

NoReply not_started() {
    return {NoReply::Reason::NotStarted, errno};
}

struct Pair {
    UniqueFd ours;
    UniqueFd theirs;
};

std::optional<Pair> make_sockets() {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) return std::nullopt;
    return Pair{UniqueFd(ends[0]), UniqueFd(ends[1])};
}

UniqueFd make_file(std::string_view bytes) {
    UniqueFd file(memfd_create("picture", MFD_CLOEXEC));
    while (file && !bytes.empty()) {
        const ssize_t written = write(file.get(), bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) return {};
        bytes.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    return file;
}

tl::unexpected<Error> cannot_start(const std::string& why) {
    return failure(ErrorCode::Internal, "cannot start the decoder: " + why);
}

struct CloseBothWays {
    int socket;

    void operator()() const { ::shutdown(socket, SHUT_RDWR); }
};

int milliseconds_until(Clock::time_point time) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(time - Clock::now()).count();
    return static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000'000));
}

/// Waits until one of the descriptors can be read or was closed by its peer.
/// @returns  the first of those; -1 if there is none by the deadline
int wait_for_any(std::initializer_list<int> descriptors, Clock::time_point deadline = Clock::time_point::max()) {
    std::vector<pollfd> polled;
    for (const int descriptor : descriptors) polled.push_back({descriptor, POLLIN, 0});
    const bool forever = deadline == Clock::time_point::max();
    while (poll(polled.data(), polled.size(), forever ? -1 : milliseconds_until(deadline)) < 0 && errno == EINTR) {
    }
    const auto found = std::ranges::find_if(polled, [](const pollfd& p) { return p.revents != 0; });
    return found == polled.end() ? -1 : found->fd;
}

/// Waits for what becomes of an order.
/// @returns  none if there is a reply
std::optional<NoReply> wait_for(const UniqueFd& outcome, Clock::time_point deadline, const std::stop_token& stop) {
    const std::stop_callback wake(stop, CloseBothWays{outcome.get()});
    pollfd polled{outcome.get(), POLLIN, 0};
    int ready = 0;
    do ready = poll(&polled, 1, milliseconds_until(deadline));
    while (ready < 0 && errno == EINTR);
    if (stop.stop_requested()) return NoReply{NoReply::Reason::Stopped};
    if (ready == 0) return NoReply{NoReply::Reason::TooSlow};
    Outcome told;
    if (recv(outcome.get(), &told, sizeof(told), 0) != static_cast<ssize_t>(sizeof(told))) return NoReply{};
    if (told.fork_error != 0) return NoReply{NoReply::Reason::NotStarted, told.fork_error};
    if (told.ended != 0) return NoReply{NoReply::Reason::Died};
    return std::nullopt;
}

template <class AnyPicture>
tl::expected<Result<AnyPicture>, NoReply> ask_helper(int orders, std::string_view bytes, std::size_t max_pixels,
                                                     const DecoderLimits& limits, Clock::time_point deadline,
                                                     const std::stop_token& stop) {
    using Reply = ReplyMemory<AnyPicture>;
    constexpr bool kColour = std::is_same_v<AnyPicture, ColourPicture>;
    auto outcome = make_sockets();
    Order order{{bytes.size(), max_pixels, kColour, limits}, make_file(bytes), Reply::make_file(max_pixels), {}};
    if (!outcome || !order.file || !order.reply) return tl::unexpected(not_started());
    order.outcome = std::move(outcome->theirs);
    if (!send_order(orders, order)) return tl::unexpected(NoReply{NoReply::Reason::HelperGone});
    order.outcome.reset();  // the helper's alone, or its death would go unseen
    // To leave closes our end, which ends the child.
    if (const auto none = wait_for(outcome->ours, deadline, stop)) return tl::unexpected(*none);
    const Reply reply(order.reply, max_pixels);
    if (!reply) return tl::unexpected(not_started());
    auto result = reply.read();
    if (!result) return tl::unexpected(NoReply{NoReply::Reason::Died});
    return *std::move(result);
}

tl::unexpected<Error> describe(const NoReply& none) {
    switch (none.reason) {
        case NoReply::Reason::Died:
            return failure(ErrorCode::Unusable, "the image could not be decoded: it made the decoder fail");
        case NoReply::Reason::TooSlow:
            return failure(ErrorCode::Unusable, "the image could not be decoded: it took too long");
        case NoReply::Reason::Stopped:
            return failure(ErrorCode::Stopped, "the decoding was stopped");
        case NoReply::Reason::NotStarted:
            return failure(ErrorCode::Internal, std::string("cannot start a decoder: ") + std::strerror(none.error));
        case NoReply::Reason::OrderLost:
        case NoReply::Reason::HelperGone:
            break;
    }
    return failure(ErrorCode::Internal, "the decoder is gone, and was not back in time");
}

}  // namespace

DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels) {
    constexpr std::chrono::milliseconds kTime{5000};
    constexpr std::uint64_t kPixelsPerMillisecond = 2000;
    constexpr std::size_t kMemory = std::size_t{24} << 20;  // to tell what is wrong
    const auto header = api::read_image_header(file, max_pixels);
    if (!header) return {kMemory, kTime};
    return {header->decoder_bytes, kTime + std::chrono::milliseconds(header->pixels() / kPixelsPerMillisecond)};
}

/// A helper that is ready.
struct DecoderBox::Running {
    ChildProgram helper;
    UniqueFd orders;
    Confinement confinement;
    Clock::time_point started;
};

Result<std::unique_ptr<DecoderBox>> DecoderBox::start(Launch launch, LimitsOf limits, Tell tell) {
    UniqueFd closing(eventfd(0, EFD_CLOEXEC));
    if (!closing) return cannot_start(std::strerror(errno));
    std::unique_ptr<DecoderBox> box(
        new DecoderBox(std::move(launch), std::move(limits), std::move(tell), std::move(closing)));
    auto running = box->launch();
    if (!running) return tl::unexpected(std::move(running.error()));
    box->confinement_ = running->confinement;
    box->set_orders(std::make_shared<const UniqueFd>(std::move(running->orders)));
    box->watcher_ = std::jthread(&DecoderBox::watch, box.get(), *std::move(running));
    return box;
}

DecoderBox::DecoderBox(Launch launch, LimitsOf limits, Tell tell, UniqueFd closing)
    : launch_(std::move(launch)), limits_(std::move(limits)), tell_(std::move(tell)), closing_(std::move(closing)) {}

DecoderBox::~DecoderBox() {
    eventfd_write(closing_.get(), 1);
}

Result<DecoderBox::Running> DecoderBox::launch() const {
    constexpr std::chrono::seconds kLongestStart{30};
    auto sockets = make_sockets();
    if (!sockets) return cannot_start(std::strerror(errno));
    const auto started = Clock::now();
    auto helper = launch_(std::move(sockets->theirs));
    if (!helper) return tl::unexpected(std::move(helper.error()));
    const auto ready = wait_for_any({sockets->ours.get(), helper->ended(), closing_.get()}, started + kLongestStart);
    Hello hello;
    if (recv(sockets->ours.get(), &hello, sizeof(hello), MSG_DONTWAIT) == static_cast<ssize_t>(sizeof(hello)))
        return Running{*std::move(helper), std::move(sockets->ours), hello.confinement, started};
    // Its end of the socket is closed a moment before it has ended.
    if (ready != sockets->ours.get()) helper->kill();
    return cannot_start("it " + helper->wait());
}

std::optional<DecoderBox::Running> DecoderBox::launch_again(Backoff& backoff, Clock::duration lived) const {
    while (true) {
        if (wait_for_any({closing_.get()}, Clock::now() + backoff.after(lived)) >= 0) return std::nullopt;
        auto running = launch();
        if (running) return *std::move(running);
        tell_(running.error().message);
        lived = {};
    }
}

void DecoderBox::watch(Running running) {
    constexpr std::chrono::seconds kToEnd{1};
    Backoff backoff;
    while (wait_for_any({running.helper.ended(), closing_.get()}) != closing_.get()) {
        set_orders(nullptr);
        ++restarts_;
        tell_("the decoder " + running.helper.wait() + ", and is started again");
        auto next = launch_again(backoff, Clock::now() - running.started);
        if (!next) return;
        running = *std::move(next);
        set_orders(std::make_shared<const UniqueFd>(std::move(running.orders)));
    }
    set_orders(nullptr);
    wait_for_any({running.helper.ended()}, Clock::now() + kToEnd);  // by itself, as nobody gives it orders any more
}

void DecoderBox::set_orders(Orders orders) {
    const std::lock_guard lock(mutex_);
    orders_ = std::move(orders);
    changed_.notify_all();
}

DecoderBox::Orders DecoderBox::wait_for_orders(const Orders& lost, Clock::time_point deadline,
                                               const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, stop, deadline, [&] { return orders_ != nullptr && orders_ != lost; });
    return orders_ == lost ? nullptr : orders_;
}

bool DecoderBox::is_ready() const {
    const std::lock_guard lock(mutex_);
    return orders_ != nullptr;
}

template <class AnyPicture>
Result<AnyPicture> DecoderBox::decode_to(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop) {
    using Reason = NoReply::Reason;
    const DecoderLimits limits = limits_(bytes);
    std::optional<Clock::time_point> give_up;
    for (Orders gone;;) {
        // That a helper ended was not this picture's fault.
        const auto orders = wait_for_orders(gone, give_up.value_or(Clock::now() + kPatience), stop);
        if (!orders) return describe({stop.stop_requested() ? Reason::Stopped : Reason::HelperGone});
        const auto deadline = Clock::now() + limits.time;
        auto reply = ask_helper<AnyPicture>(orders->get(), bytes, max_pixels, limits, deadline, stop);
        if (reply) return *std::move(reply);
        const auto reason = reply.error().reason;
        if (reason == Reason::Died || reason == Reason::TooSlow) ++deaths_;
        if (reason == Reason::HelperGone) gone = orders;
        if (!give_up) give_up = Clock::now() + kPatience;
        const bool is_lost = reason == Reason::OrderLost || reason == Reason::HelperGone;
        if (!is_lost || Clock::now() > *give_up) return describe(reply.error());
    }
}

Result<Picture> DecoderBox::decode(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop) {
    return decode_to<Picture>(bytes, max_pixels, stop);
}

Result<ColourPicture> DecoderBox::decode_colour(std::string_view bytes, std::size_t max_pixels,
                                                const std::stop_token& stop) {
    return decode_to<ColourPicture>(bytes, max_pixels, stop);
}

}  // namespace ccdt::server
