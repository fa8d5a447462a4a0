#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "core/halftone/picture.h"
#include "core/result.h"
#include "server/child_program.h"
#include "server/decoder/decoder_confinement.h"
#include "server/decoder/decoder_sandbox.h"
#include "server/http/unique_fd.h"

namespace ccdt::server {

/// Of memory what a reader needs for a picture as the file's header tells it, of time what a slow machine takes.
DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels);

/// Decodes pictures of strangers in processes that may crash, hang or eat memory: each costs its own picture only.
///
/// A helper forks a child for each picture. Should the helper end it is started again, and what it had not done is
/// given to the new one. See decoder_helper.h for how they end, decoder_confinement.h and decoder_sandbox.h for what
/// they may do.
class DecoderBox {
public:
    using LimitsOf = std::function<DecoderLimits(std::string_view file)>;

    /// Starts a process that becomes the helper, by run_decoder_helper; from any thread.
    using Launch = std::function<Result<ChildProgram>(UniqueFd orders)>;

    /// Is told in words that the helper ended or does not start; by a thread of the box.
    using Tell = std::function<void(const std::string&)>;

    /// Starts the helper and waits until it is ready. Errors: Internal.
    /// @param limits  for a file
    static Result<std::unique_ptr<DecoderBox>> start(Launch launch, LimitsOf limits, Tell tell);

    /// Ends the helper, and with it what it still does.
    ~DecoderBox();

    DecoderBox(const DecoderBox&) = delete;
    DecoderBox& operator=(const DecoderBox&) = delete;

    /// What the decoder makes of a file, to the byte. May be called from any thread; a stop ends it at once.
    ///
    /// Errors: the decoder's own; Unusable if it crashed, passed a limit or gave nonsense; Stopped; Internal if the
    /// machine lacks processes or descriptors, or the helper was lost and there was no other for kPatience.
    Result<Picture> decode(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop);
    Result<ColourPicture> decode_colour(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop);

    /// Pictures so far whose child crashed, passed a limit or gave nonsense.
    std::uint64_t deaths() const { return deaths_; }

    /// Times that the helper ended, and was or is being started again.
    std::uint64_t restarts() const { return restarts_; }

    /// Whether there is a helper now.
    bool is_ready() const;

    /// What the first helper found in force.
    const Confinement& confinement() const { return confinement_; }

    static constexpr std::chrono::seconds kPatience{5};

private:
    using Orders = std::shared_ptr<const UniqueFd>;  ///< the socket to a helper
    struct Running;

    DecoderBox(Launch launch, LimitsOf limits, Tell tell, UniqueFd closing);

    Result<Running> launch() const;
    void watch(Running running);
    /// @returns  none if the box is to end first
    std::optional<Running> launch_again(Backoff& backoff, std::chrono::steady_clock::duration lived) const;
    void set_orders(Orders orders);
    Orders wait_for_orders(const Orders& lost, std::chrono::steady_clock::time_point deadline,
                           const std::stop_token& stop);

    template <class AnyPicture>
    Result<AnyPicture> decode_to(std::string_view bytes, std::size_t max_pixels, const std::stop_token& stop);

    const Launch launch_;
    const LimitsOf limits_;
    const Tell tell_;
    const UniqueFd closing_;  ///< readable once the box is to end
    Confinement confinement_;
    std::atomic<std::uint64_t> deaths_ = 0;
    std::atomic<std::uint64_t> restarts_ = 0;

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    Orders orders_;  ///< none while there is no helper; guarded by the mutex

    std::jthread watcher_;
};

}  // namespace ccdt::server
