// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "api/decode/decode.h"
#include "server/decoder/decoder_client.h"
#include "server/decoder/decoder_supervisor.h"

namespace ccdt::server {

/// Decodes pictures, shapefiles and mesh files in ccdt-decoder, which is started when it is first needed and ends with
/// this object.
class Decoding {
public:
    Decoding() = default;
    Decoding(const Decoding&) = delete;
    Decoding& operator=(const Decoding&) = delete;

    /// Starts ccdt-decoder, unless it runs. Does not wait until it is ready, which takes 0.2 s.
    /// Errors: Internal; the message names the package that contains the program.
    Result<void> start();

    /// Returns functions for the computation of answers. This object must outlive them.
    api::Decode functions();

    /// Converts a zipped shapefile to GeoJSON.
    /// @param object  name of the shapefile; empty: the only one
    /// @param memory  memory limit in bytes
    /// Errors: those of DecoderClient::read_shapefile() and start().
    Result<std::string> read_shapefile(const std::string& archive, const std::string& object, std::size_t memory);

private:
    std::unique_ptr<DecoderSupervisor> supervisor_;
    std::unique_ptr<DecoderClient> client_;
};

}  // namespace ccdt::server
