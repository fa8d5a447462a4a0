// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_client.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "api/image/image_header.h"
#include "api/map/shapefile_reader.h"
#include "server/decoder/decoder_protocol.h"
#include "server/processes/messages.h"

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;

/// Elapsed time that a child may take after it has begun, as a multiple of its limit of processor time. The maximum
/// wait for a child to begin is added.
constexpr int kMaxPerProcessorTime = 3;

/// The reason why there is no reply.
struct NoReply {
    enum class Reason { Died, Killed, TooSlow, Late, Stopped, NotStarted, OrderLost, NoHelper };
    Reason reason = Reason::OrderLost;
    int error = 0;  ///< errno if the reason is NotStarted
};

NoReply not_started() {
    return {NoReply::Reason::NotStarted, errno};
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

/// Receives the next report about an order.
tl::expected<Outcome, NoReply> next_report(const UniqueFd& outcome, Clock::time_point deadline,
                                           const std::stop_token& stop) {
    pollfd polled{outcome.get(), POLLIN, 0};
    int ready = 0;
    do ready = poll(&polled, 1, milliseconds_until(deadline));
    while (ready < 0 && errno == EINTR);
    if (stop.stop_requested()) return tl::unexpected(NoReply{NoReply::Reason::Stopped});
    if (ready == 0) return tl::unexpected(NoReply{NoReply::Reason::Late});
    Outcome report;
    if (recv(outcome.get(), &report, sizeof(report), 0) != static_cast<ssize_t>(sizeof(report)))
        return tl::unexpected(NoReply{});
    return report;
}

/// Waits until an order is done or has failed.
/// @param to_begin  time within which a child must begin
/// @param to_end    time within which the child must end after it has begun
/// @param used_us   is increased by the processor time of the child, in microseconds
/// @param progress  receives the share of the file that is decoded, in (0, 1]
/// @returns         none if the child has written its reply
std::optional<NoReply> wait_for(const UniqueFd& outcome, Clock::duration to_begin, Clock::duration to_end,
                                const std::stop_token& stop, std::atomic<std::int64_t>& used_us,
                                const std::function<void(double)>& progress) {
    const std::stop_callback wake(stop, CloseBothWays{outcome.get()});
    auto report = next_report(outcome, Clock::now() + to_begin, stop);
    if (report && report->begun != 0) {
        const auto begun = Clock::now();
        int reports = 0;
        for (double decoded = 0; report && report->begun != 0 && ++reports <= Outcome::kMaxBegun;) {
            if (progress && report->decoded > decoded && report->decoded <= 1) progress(decoded = report->decoded);
            report = next_report(outcome, begun + to_end, stop);
        }
        // The child has one thread, and may be under the control of an attacker.
        const auto elapsed = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begun).count();
        used_us += report ? std::clamp<std::int64_t>(report->used_us, 0, elapsed) : elapsed;
    }
    if (!report) return report.error();
    if (report->fork_error != 0) return NoReply{NoReply::Reason::NotStarted, report->fork_error};
    if (report->no_helper != 0) return NoReply{NoReply::Reason::NoHelper};
    if (report->too_slow != 0) return NoReply{NoReply::Reason::TooSlow};
    if (report->killed != 0) return NoReply{NoReply::Reason::Killed};
    if (report->ended != 0 || report->begun != 0) return NoReply{NoReply::Reason::Died};
    return std::nullopt;
}

/// Type of the result that a reply contains.
template <class Reply>
using ResultOf = typename decltype(std::declval<const Reply&>().read())::value_type;

/// Sends one order to a helper, and waits for the reply.
/// @param text       the fixed-size part of the order
/// @param for_child  see DecoderWaits
/// @param progress   as api::Reading::progress; may be empty
template <class Reply>
tl::expected<ResultOf<Reply>, NoReply> ask_helper(const DecoderClient::PassOrder& pass_order, std::string_view bytes,
                                                  const Order::Text& text, std::chrono::milliseconds for_child,
                                                  const std::stop_token& stop, std::atomic<std::int64_t>& used_us,
                                                  const std::function<void(double)>& progress) {
    const auto max_size = static_cast<std::size_t>(text.max_size);
    auto outcome = make_sockets(SOCK_SEQPACKET);
    Order order{text, make_file(bytes), Reply::make_file(max_size), {}};
    if (!outcome || !order.file || !order.reply) return tl::unexpected(not_started());
    order.outcome = std::move(outcome->theirs);
    if (!pass_order(order, stop))
        return tl::unexpected(NoReply{stop.stop_requested() ? NoReply::Reason::Stopped : NoReply::Reason::NoHelper});
    order.outcome.reset();  // so that this end is closed when the helper ends
    // When this function returns, our end of the socket is closed, which ends the child.
    const auto to_end = for_child + kMaxPerProcessorTime * text.limits.time;
    if (const auto none = wait_for(outcome->ours, for_child, to_end, stop, used_us, progress))
        return tl::unexpected(*none);
    const Reply reply(order.reply, max_size);
    if (!reply) return tl::unexpected(not_started());
    auto result = reply.read();
    if (!result) return tl::unexpected(NoReply{NoReply::Reason::Died});
    return *std::move(result);
}

/// Returns the error that describes why there is no reply.
/// @param what  subject of the message, such as "the image"
tl::unexpected<Error> describe(const NoReply& none, const std::string& what) {
    switch (none.reason) {
        case NoReply::Reason::Died:
            return failure(ErrorCode::Unusable, what + " could not be decoded: it made the decoder fail");
        case NoReply::Reason::Killed:
            return failure(ErrorCode::Unavailable, "the process that decoded " + what + " was killed twice");
        case NoReply::Reason::TooSlow:
            return failure(ErrorCode::Unusable, what + " could not be decoded: it took too long");
        case NoReply::Reason::Late:
            return failure(ErrorCode::Unavailable, "the server was too busy to decode " + what);
        case NoReply::Reason::Stopped:
            return failure(ErrorCode::Stopped, "the decoding was stopped");
        case NoReply::Reason::NotStarted:
            return failure(ErrorCode::Internal, std::string("cannot start a decoder: ") + std::strerror(none.error));
        case NoReply::Reason::OrderLost:
        case NoReply::Reason::NoHelper:
            break;
    }
    return failure(ErrorCode::Unavailable, "the decoder has ended, and was not restarted in time");
}

/// Returns the processor time that a slow machine needs to decode pixels.
std::chrono::seconds time_for(std::uint64_t pixels) {
    constexpr std::uint64_t kPixelsPerMillisecond = 2000;
    return std::chrono::ceil<std::chrono::seconds>(std::chrono::milliseconds(pixels / kPixelsPerMillisecond));
}

/// Returns the subject of error messages about a file.
std::string subject_of(Order::Product product) {
    if (product == Order::Product::Map) return "the shapefile";
    return product == Order::Product::Surface ? "the mesh" : "the image";
}

/// Sends orders to decode a file until there is a reply. Repeats an order only if it was lost because its helper ended,
/// and once if its child was killed from outside.
template <class Reply>
ResultOf<Reply> decode_by(const DecoderClient::PassOrder& pass_order, std::string_view bytes, Order::Text text,
                          const std::stop_token& stop, const DecoderWaits& waits, DecoderClient::Counts& counts,
                          const std::function<void(double)>& progress = {}) {
    using Reason = NoReply::Reason;
    text.bytes = bytes.size();
    std::optional<Clock::time_point> retry_until;
    bool was_killed = false;
    while (true) {
        const Clock::duration patience = retry_until ? *retry_until - Clock::now() : waits.for_helper;
        text.patience_ms = std::chrono::ceil<std::chrono::milliseconds>(patience).count();
        auto reply = ask_helper<Reply>(pass_order, bytes, text, waits.for_child, stop, counts.used_us, progress);
        if (reply) return *std::move(reply);
        const auto reason = reply.error().reason;
        if (reason == Reason::Died || reason == Reason::Killed || reason == Reason::TooSlow) ++counts.deaths;
        if (!retry_until) retry_until = Clock::now() + waits.for_helper;
        // The file does not cause the end of the helper or the kill, so the order is repeated.
        const bool was_lost = reason == Reason::OrderLost && Clock::now() <= *retry_until;
        const bool is_first_kill = reason == Reason::Killed && !std::exchange(was_killed, true);
        if (!was_lost && !is_first_kill) return describe(reply.error(), subject_of(text.product));
    }
}

}  // namespace

DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels) {
    constexpr std::chrono::seconds kTime{5};
    constexpr std::size_t kMemory = std::size_t{24} << 20;  // enough to find the error in the file
    const auto header = api::read_image_header(file, max_pixels);
    if (!header) return {kMemory, kTime};
    return {header->decoder_bytes, kTime + time_for(header->pixels())};
}

DecoderLimits surface_limits(std::string_view file, const api::SurfaceHeader& header) {
    constexpr std::chrono::seconds kTime{10};
    constexpr std::size_t kBytesPerMillisecond = 4000;
    constexpr std::size_t kTexelsPerMillisecond = 2000;
    const std::chrono::milliseconds more(file.size() / kBytesPerMillisecond + header.texels / kTexelsPerMillisecond);
    return {static_cast<std::size_t>(header.decoder_bytes), kTime + std::chrono::ceil<std::chrono::seconds>(more)};
}

DecoderLimits shapefile_limits(std::size_t max_bytes) {
    constexpr std::chrono::seconds kTime{10};
    return {api::shapefile_memory(max_bytes), kTime};
}

template <class AnyPicture>
Result<AnyPicture> DecoderClient::decode_to(std::string_view bytes, const api::Reading& reading,
                                            const std::stop_token& stop) {
    Order::Text text;
    text.max_size = reading.max_pixels;
    text.product = std::is_same_v<AnyPicture, ColourPicture> ? Order::Product::Colour : Order::Product::Grey;
    text.reduce = reading.reduce;
    text.is_stack = reading.is_stack ? 1 : 0;
    text.ground = reading.ground;
    text.limits = limits_(bytes, reading.max_pixels);
    if (reading.is_stack) text.limits.time += time_for(reading.max_pixels);
    return decode_by<ReplyMemory<AnyPicture>>(pass_order_, bytes, text, stop, waits_, counts_, reading.progress);
}

Result<Picture> DecoderClient::decode(std::string_view bytes, const api::Reading& reading,
                                      const std::stop_token& stop) {
    return decode_to<Picture>(bytes, reading, stop);
}

Result<ColourPicture> DecoderClient::decode_colour(std::string_view bytes, const api::Reading& reading,
                                                   const std::stop_token& stop) {
    return decode_to<ColourPicture>(bytes, reading, stop);
}

Result<std::string> DecoderClient::read_shapefile(std::string_view archive, const api::ShapefileReading& reading,
                                                  const std::stop_token& stop) {
    if (reading.object.size() > Order::kLongestName)
        return failure(ErrorCode::Malformed,
                       "object must be a name of at most " + std::to_string(Order::kLongestName) + " bytes", "object");
    Order::Text text;
    text.max_size = reading.max_bytes;
    text.product = Order::Product::Map;
    reading.object.copy(text.object.data(), reading.object.size());
    text.limits = shapefile_limits(reading.max_bytes);
    return decode_by<ReplyText>(pass_order_, archive, text, stop, waits_, counts_);
}

Result<api::SurfaceContents> DecoderClient::read_surface(std::string_view bytes, const api::SurfaceHeader& header,
                                                         const std::stop_token& stop) {
    Order::Text text;
    text.max_size = ReplySurface::max_bytes(header);
    text.product = Order::Product::Surface;
    text.surface = header;
    text.limits = surface_limits(bytes, header);
    return decode_by<ReplySurface>(pass_order_, bytes, text, stop, waits_, counts_);
}

api::Decode DecoderClient::functions() {
    return {[this](std::string_view bytes, const api::Reading& reading, const std::stop_token& stop) {
                return decode(bytes, reading, stop);
            },
            [this](std::string_view bytes, const api::Reading& reading, const std::stop_token& stop) {
                return decode_colour(bytes, reading, stop);
            },
            [this](std::string_view bytes, const api::SurfaceHeader& header, const std::stop_token& stop) {
                return read_surface(bytes, header, stop);
            }};
}

}  // namespace ccdt::server
