// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/work/shapefile_request.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "api/map/shapefile_reader.h"
#include "server/http/http.h"

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

Result<ComputeRequest> with_geojson(const ComputeRequest& request, std::size_t max_bytes, const ReadShapefile& read,
                                    const std::stop_token& stop) {
    std::optional<std::string> object;
    ComputeRequest converted{request.path, {}, {}, request.accept, {}};
    for (auto& [name, value] : parse_query(request.query)) {
        if (name == "object") {
            if (object) return failure(ErrorCode::Malformed, "object is given twice", "object");
            object = std::move(value);
        } else {
            if (!converted.query.empty()) converted.query += '&';
            converted.query += encode_percent(name) + '=' + encode_percent(value);
        }
    }
    auto text = read(request.body, {object.value_or(""), max_bytes}, stop);
    if (!text) return tl::unexpected(std::move(text.error()));
    converted.body = *std::move(text);
    return converted;
}

}  // namespace ccdt::server
