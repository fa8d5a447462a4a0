#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>
#include <string_view>

#include <sys/types.h>

#include "core/halftone/picture.h"
#include "core/result.h"
#include "server/decoder/decoder_helper.h"
#include "server/decoder/decoder_sandbox.h"
#include "server/http/unique_fd.h"

namespace ccdt::server {

/// Of memory what a reader needs for a picture as the file's header tells it, of time what a slow machine takes.
DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels);

/// Decodes pictures of strangers in processes that may crash, hang or eat memory: each costs its own picture only.
///
/// A helper, forked while the program has one thread, forks a child for each picture. See decoder_helper.h for how
/// they end, and decoder_sandbox.h for what a child may do.
class DecoderBox {
public:
    using LimitsOf = std::function<DecoderLimits(std::string_view file)>;

    /// Starts the helper and waits until it is ready. To be called by a thread that outlives the box, before there are
    /// others. Errors: Internal.
    /// @param limits  for a file
    static Result<std::unique_ptr<DecoderBox>> start(const Decoder& decoder, LimitsOf limits);

    /// Ends the helper, and with it what it still does.
    ~DecoderBox();

    DecoderBox(const DecoderBox&) = delete;
    DecoderBox& operator=(const DecoderBox&) = delete;

    /// What the decoder makes of a file, to the byte. May be called from any thread; a stop ends it at once.
    ///
    /// Errors: the decoder's own; Unusable if it crashed, passed a limit or gave nonsense; Stopped; Internal if the
    /// machine lacks processes or descriptors, or the helper was lost.
    Result<Picture> decode(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop);
    Result<ColourPicture> decode_colour(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop);

    /// Pictures so far whose child crashed, passed a limit or gave nonsense.
    std::uint64_t deaths() const { return deaths_; }

    /// errno for why system calls are not filtered; 0: they are.
    int filter_error() const { return filter_error_; }

private:
    DecoderBox(UniqueFd orders, pid_t keeper, int filter_error, LimitsOf limits);

    template <class AnyPicture>
    Result<AnyPicture> decode_to(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop);

    const LimitsOf limits_;
    const pid_t keeper_;
    const int filter_error_;
    UniqueFd orders_;
    std::atomic<std::uint64_t> deaths_ = 0;
};

}  // namespace ccdt::server
