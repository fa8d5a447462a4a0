// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/shapefile_request.h"

#include <utility>

#include "api/map/object_option.h"
#include "server/http/http.h"

namespace ccdt::server {

Result<ComputeRequest> with_geojson(const ComputeRequest& request, std::size_t max_bytes, const ReadShapefile& read,
                                    const std::stop_token& stop, api::Timings& timings) {
    auto options = parse_query(request.query);
    const auto object = api::take_object(options);
    if (!object) return tl::unexpected(object.error());
    ComputeRequest converted{request.path, {}, {}, request.accept, {}};
    for (const auto& [name, value] : options) {
        if (!converted.query.empty()) converted.query += '&';
        converted.query += encode_percent(name) + '=' + encode_percent(value);
    }
    auto text = read(request.body, {*object, max_bytes}, stop, timings);
    if (!text) return tl::unexpected(std::move(text.error()));
    converted.body = *std::move(text);
    return converted;
}

}  // namespace ccdt::server
