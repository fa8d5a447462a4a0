// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

#include "api/image/image_codec.h"
#include "api/map/shapefile_parts.h"
#include "core/halftone/picture.h"
#include "core/result.h"
#include "server/decoder/decoder_sandbox.h"

namespace ccdt::server {

struct Order;

/// Limits for a file: the memory that a reader needs for a picture as its header tells it, the time of a slow machine.
DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels);

/// Limits for a zipped shapefile: the memory that its reader needs, the time of a slow machine.
/// @param max_bytes  as api::ShapefileReading has it
DecoderLimits shapefile_limits(std::size_t max_bytes);

/// Has pictures decoded in the box, wherever that is. May be used from any thread.
class DecoderClient {
public:
    using LimitsOf = std::function<DecoderLimits(std::string_view file, std::size_t max_pixels)>;

    /// Hands an order on to a helper; false: there is none, and none will be there in time.
    using Hand = std::function<bool(const Order& order, const std::stop_token& stop)>;

    explicit DecoderClient(Hand hand, LimitsOf limits = decoder_limits)
        : hand_(std::move(hand)), limits_(std::move(limits)) {}

    /// Decodes a file as the decoder does, to the byte; a stop ends it at once. An order that a helper took along when
    /// it ended is given again.
    ///
    /// Errors: the decoder's own; Unusable if it crashed, passed a limit or gave nonsense; Stopped; Internal if the
    /// machine lacks processes or descriptors, or the helper was lost and there was no other in time.
    Result<Picture> decode(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop);
    Result<ColourPicture> decode_colour(std::string_view bytes, const api::Reading& reading,
                                        const std::stop_token& stop);

    /// Reads a zipped shapefile as api::read_shapefile does, to GeoJSON. Errors besides: as above.
    Result<std::string> read_shapefile(std::string_view archive, const api::ShapefileReading& reading,
                                       const std::stop_token& stop);

    /// The two functions, as api takes them. The client must outlive them.
    api::Decode functions();

    /// Files so far whose child crashed, passed a limit or gave nonsense.
    std::uint64_t deaths() const { return deaths_; }

private:
    template <class AnyPicture>
    Result<AnyPicture> decode_to(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop);

    const Hand hand_;
    const LimitsOf limits_;
    std::atomic<std::uint64_t> deaths_ = 0;
};

}  // namespace ccdt::server
