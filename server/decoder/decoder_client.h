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

#include "api/decode/decode.h"
#include "api/map/shapefile_parts.h"
#include "api/surface/surface_reader.h"
#include "core/base/result.h"
#include "core/picture/picture.h"
#include "server/decoder/decoder_sandbox.h"

namespace ccdt::server {

struct Order;

/// Returns the limits for decoding a picture: the memory that the format's reader needs for the size in the header, and
/// a processor time that suffices on a slow machine.
DecoderLimits decoder_limits(std::string_view file, std::size_t max_pixels);

/// Returns the limits for reading a zipped shapefile: the memory that its reader needs, and a processor time that
/// suffices on a slow machine.
/// @param max_bytes  see api::ShapefileReading
DecoderLimits shapefile_limits(std::size_t max_bytes);

/// Returns the limits for reading a mesh file: the memory that SurfaceHeader states, and a processor time that suffices
/// on a slow machine.
DecoderLimits surface_limits(std::string_view file, const api::SurfaceHeader& header);

/// Limits of the time that an order waits.
struct DecoderWaits {
    /// Maximum time that an order waits for a restart of the helper. An order is lost if its helper ends. Lost
    /// orders are repeated for this time after the first loss.
    std::chrono::milliseconds for_helper{5'000};

    /// Maximum time that an order waits for a child to begin. It includes the first start of the helper, which
    /// loads many libraries, and it suffices on a busy machine.
    std::chrono::milliseconds for_child{30'000};
};

/// Sends pictures, shapefiles and mesh files to a DecoderSupervisor, which may belong to another process, and returns
/// the decoded results. May be used from any thread.
class DecoderClient {
public:
    using LimitsOf = std::function<DecoderLimits(std::string_view file, std::size_t max_pixels)>;

    /// Passes an order to a helper; returns false if no helper is available in time.
    using PassOrder = std::function<bool(const Order& order, const std::stop_token& stop)>;

    explicit DecoderClient(PassOrder pass_order, LimitsOf limits = decoder_limits, DecoderWaits waits = {})
        : pass_order_(std::move(pass_order)), limits_(std::move(limits)), waits_(waits) {}

    /// Decodes a picture. The result is the same as if the calling process decoded it. A stop request takes effect at
    /// once.
    ///
    /// If the child is killed from outside, for example because the machine ran out of memory, the file is decoded once
    /// again.
    /// Errors: those of the picture readers; Unusable if the child crashed, exceeded its memory or processor time, or
    /// wrote an invalid reply; Stopped; Unavailable if the machine is too busy, so that no helper is available or a
    /// child does not begin or end in time, or if two children were killed from outside; Internal if the machine lacks
    /// processes or descriptors.
    Result<Picture> decode(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop);
    Result<ColourPicture> decode_colour(std::string_view bytes, const api::Reading& reading,
                                        const std::stop_token& stop);

    /// Converts a zipped shapefile to GeoJSON. Errors: those of api::read_shapefile, and those of decode() except
    /// errors of picture readers.
    Result<std::string> read_shapefile(std::string_view archive, const api::ShapefileReading& reading,
                                       const std::stop_token& stop);

    /// Reads a mesh file. Errors: those of api::read_surface, and those of decode() except errors of picture readers.
    Result<api::SurfaceContents> read_surface(std::string_view bytes, const api::SurfaceHeader& header,
                                              const std::stop_token& stop);

    /// Returns decode(), decode_colour() and read_surface() as functions for api. The client must outlive these
    /// functions.
    api::Decode functions();

    /// Returns the number of children so far that crashed, were killed, exceeded a limit or wrote an invalid reply.
    std::uint64_t deaths() const { return counts_.deaths; }

    /// Returns the processor time of all children so far. If a child does not report its time, its elapsed time is
    /// counted.
    std::chrono::microseconds processor_time() const { return std::chrono::microseconds(counts_.used_us); }

    struct Counts {
        std::atomic<std::uint64_t> deaths = 0;
        std::atomic<std::int64_t> used_us = 0;
    };

private:
    template <class AnyPicture>
    Result<AnyPicture> decode_to(std::string_view bytes, const api::Reading& reading, const std::stop_token& stop);

    const PassOrder pass_order_;
    const LimitsOf limits_;
    const DecoderWaits waits_;
    Counts counts_;
};

}  // namespace ccdt::server
