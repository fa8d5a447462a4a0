// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
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

/// Returns the limits for decoding a picture. The memory is the amount that a reader needs for a file with this header;
/// the processor time is enough for a slow machine.
DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels);

/// Returns the limits for reading a zipped shapefile: the memory that its reader needs, and a processor time that is
/// enough for a slow machine.
/// @param max_bytes  see api::ShapefileReading
DecoderLimits shapefile_limits(std::size_t max_bytes);

/// Has pictures and shapefiles decoded by a DecoderBox, which may belong to another process. May be used from any
/// thread.
class DecoderClient {
public:
    using LimitsOf = std::function<DecoderLimits(std::string_view file, std::size_t max_pixels)>;

    /// Passes an order on to a helper; returns false if no helper is available in time.
    using PassOrder = std::function<bool(const Order& order, const std::stop_token& stop)>;

    /// Time that an order may wait for a helper, and the same time again for a child to begin. An order that is lost
    /// because its helper ended is repeated until the same time has passed since the first loss.
    static constexpr std::chrono::milliseconds kLongestWait{5000};

    explicit DecoderClient(PassOrder pass_order, LimitsOf limits = decoder_limits,
                           std::chrono::milliseconds longest_wait = kLongestWait)
        : pass_order_(std::move(pass_order)), limits_(std::move(limits)), longest_wait_(longest_wait) {}

    /// Decodes a file. The result is the same as if this process had decoded the file. A stop ends the decoding at
    /// once. If an order was lost because its helper ended, the order is repeated.
    ///
    /// Errors: those of the picture readers; Unusable if the decoder crashed, exceeded its memory or its processor
    /// time, or wrote an invalid reply; Stopped; Unavailable if no helper was available or no child began in time, or
    /// if a child did not end in time although it had processor time left; Internal if the machine lacks processes or
    /// descriptors.
    Result<Picture> decode(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop);
    Result<ColourPicture> decode_colour(std::string_view bytes, const api::Reading& reading,
                                        const std::stop_token& stop);

    /// Converts a zipped shapefile to GeoJSON: see api::read_shapefile. Errors: those of that function, and those of
    /// decode() that do not come from the picture readers.
    Result<std::string> read_shapefile(std::string_view archive, const api::ShapefileReading& reading,
                                       const std::stop_token& stop);

    /// Returns the two decode functions in the form that api takes. The client must outlive them.
    api::Decode functions();

    /// Number of files so far whose child crashed, exceeded a limit or wrote an invalid reply.
    std::uint64_t deaths() const { return deaths_; }

private:
    template <class AnyPicture>
    Result<AnyPicture> decode_to(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop);

    const PassOrder pass_order_;
    const LimitsOf limits_;
    const std::chrono::milliseconds longest_wait_;
    std::atomic<std::uint64_t> deaths_ = 0;
};

}  // namespace ccdt::server
