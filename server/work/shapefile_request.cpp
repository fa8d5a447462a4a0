// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/work/shapefile_request.h"

#include <optional>
#include <utility>

#include "server/http/http.h"

namespace ccdt::server {

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
