// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/shapefile_cost.h"

#include <algorithm>

#include "api/map/shapefile_reader.h"

namespace ccdt::server {

std::size_t max_shapefile_bytes(std::size_t max_body, std::size_t memory) {
    constexpr std::size_t kShare = 12;  // keeps cost_of_shapefile() below the memory limit
    return std::min(max_body, memory / kShare);
}

api::Cost cost_of_shapefile(std::string_view archive, std::size_t max_bytes) {
    constexpr double kSecondsPerByte = 2e-7;
    constexpr double kSeconds = 5e-3;
    // The text exists twice: as the decoder's reply and as the new body.
    return {api::shapefile_memory(max_bytes) + 2 * max_bytes,
            kSeconds + kSecondsPerByte * static_cast<double>(archive.size())};
}

}  // namespace ccdt::server
