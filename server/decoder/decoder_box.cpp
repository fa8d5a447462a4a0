#include "server/decoder/decoder_box.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "api/image/image_header.h"
#include "server/decoder/decoder_protocol.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Why there is no reply.
struct NoReply {
    enum class Reason { Died, TooSlow, Stopped, NotStarted, HelperLost };
    Reason reason = Reason::HelperLost;
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

struct CloseBothWays {
    int socket;

    void operator()() const { ::shutdown(socket, SHUT_RDWR); }
};

int milliseconds_until(Clock::time_point time) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(time - Clock::now()).count();
    return static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000'000));
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
    if (!send_order(orders, order)) return tl::unexpected(NoReply{});
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
        case NoReply::Reason::HelperLost:
            break;
    }
    return failure(ErrorCode::Internal, "the decoder's helper is gone");
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

Result<std::unique_ptr<DecoderBox>> DecoderBox::start(const Decoder& decoder, LimitsOf limits) {
    auto sockets = make_sockets();
    const pid_t keeper = sockets ? fork() : -1;
    if (keeper < 0) {
        return failure(ErrorCode::Internal, std::string("cannot start the decoder's helper: ") + std::strerror(errno));
    }
    if (keeper == 0) {
        sockets->ours.reset();
        run_decoder_helper(std::move(sockets->theirs), decoder);
    }
    sockets->theirs.reset();
    Hello hello;
    if (recv(sockets->ours.get(), &hello, sizeof(hello), 0) != static_cast<ssize_t>(sizeof(hello))) {
        waitpid(keeper, nullptr, 0);
        return failure(ErrorCode::Internal, "cannot start the decoder's helper: it ended at once");
    }
    return std::unique_ptr<DecoderBox>(
        new DecoderBox(std::move(sockets->ours), keeper, hello.filter_error, std::move(limits)));
}

DecoderBox::DecoderBox(UniqueFd orders, pid_t keeper, int filter_error, LimitsOf limits)
    : limits_(std::move(limits)), keeper_(keeper), filter_error_(filter_error), orders_(std::move(orders)) {}

DecoderBox::~DecoderBox() {
    orders_.reset();
    while (waitpid(keeper_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

template <class AnyPicture>
Result<AnyPicture> DecoderBox::decode_to(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop) {
    const DecoderLimits limits = limits_(bytes);
    const auto deadline = Clock::now() + limits.time;
    auto reply = ask_helper<AnyPicture>(orders_.get(), bytes, max_pixels, limits, deadline, stop);
    // Its keeper has another one, and it was not this picture's fault.
    if (!reply && reply.error().reason == NoReply::Reason::HelperLost) {
        reply = ask_helper<AnyPicture>(orders_.get(), bytes, max_pixels, limits, deadline, stop);
    }
    if (reply) return *std::move(reply);
    const auto reason = reply.error().reason;
    if (reason == NoReply::Reason::Died || reason == NoReply::Reason::TooSlow) ++deaths_;
    return describe(reply.error());
}

Result<Picture> DecoderBox::decode(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop) {
    return decode_to<Picture>(bytes, max_pixels, stop);
}

Result<ColourPicture> DecoderBox::decode_colour(std::string_view bytes, std::size_t max_pixels,
                                                const std::stop_token& stop) {
    return decode_to<ColourPicture>(bytes, max_pixels, stop);
}

}  // namespace ccdt::server
