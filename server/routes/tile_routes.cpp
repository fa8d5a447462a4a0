// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/routes/tile_routes.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <utility>

#include "api/json/json_document.h"
#include "api/text/numbers.h"
#include "api/text/text.h"
#include "server/http/compression.h"
#include "server/http/entity_tag.h"
#include "server/routes/job_routes.h"

namespace ccdt::server {
namespace {

constexpr int kMaxZoom = 31;

/// Position of a tile in a path.
struct TilePlace {
    int zoom = 0;
    std::uint32_t column = 0, row = 0;
};

/// Parses `zoom/column/row`; none if there is no such tile.
std::optional<TilePlace> parse_place(std::string_view path) {
    std::array<std::uint32_t, 3> numbers{};
    for (std::uint32_t& number : numbers) {
        const auto parsed = api::parse_number<std::uint32_t>(api::take_until(path, "/"));
        if (!parsed) return std::nullopt;
        number = *parsed;
    }
    const auto [zoom, column, row] = numbers;
    if (zoom > kMaxZoom || column >> zoom != 0 || row >> zoom != 0) return std::nullopt;
    return TilePlace{static_cast<int>(zoom), column, row};
}

tl::unexpected<Problem> damaged() {
    return problem(500, "the archive of tiles is damaged");
}

std::string numbers_of(std::initializer_list<double> numbers) {
    std::string list = "[";
    for (const double number : numbers) {
        if (list.size() > 1) list += ',';
        api::append_shortest(list, number);
    }
    return list += ']';
}

/// Returns the scheme and the host by which the client reached this server.
std::string origin_of(const Request& request) {
    const bool is_secure = request.header("X-Forwarded-Proto") == "https";
    return (is_secure ? "https://" : "http://") + request.authority;
}

/// Adds the header that lets clients keep an answer, which never changes.
void allow_keeping(Response& response) {
    response.headers.push_back({"Cache-Control", "private, max-age=3600"});
}

}  // namespace

HttpResult<TileRoutes::Found> TileRoutes::find(const std::string& id, const Connection& connection) {
    auto job = jobs_.find(id, connection.key());
    if (!job) return tl::unexpected(std::move(job.error()));
    if (job->status != JobStatus::Succeeded) return no_result(*job);
    if (job->media_type != "application/vnd.pmtiles" || job->result_bytes < api::TileArchive::kHeader)
        return problem(404, "the result of the job has no tiles: its format is not pmtiles");
    const auto header = results_.read(*job, 0, api::TileArchive::kHeader);
    if (!header) return tl::unexpected(header.error());
    const auto archive = api::read_header(*header);
    if (!archive) return damaged();
    return Found{*std::move(job), *archive};
}

/// Reads bytes of a section of an archive.
HttpResult<std::string> TileRoutes::read(const Found& found, const api::TileArchive::Section& section,
                                         std::uint64_t offset, std::uint64_t length) {
    const std::uint64_t size = found.job.result_bytes;
    if (section.offset > size || offset > size - section.offset || length > size - section.offset - offset)
        return damaged();
    return results_.read(found.job, section.offset + offset, length);
}

HttpResult<std::vector<api::TileEntry>> TileRoutes::directory(const Found& found,
                                                              const api::TileArchive::Section& section,
                                                              std::uint64_t offset, std::uint64_t length) {
    return read(found, section, offset, length).and_then([](const std::string& bytes) {
        auto entries = api::read_directory(bytes);
        return entries ? HttpResult<std::vector<api::TileEntry>>(*std::move(entries)) : damaged();
    });
}

/// Reads a tile as it is stored; none if the archive does not have it.
HttpResult<std::optional<std::string>> TileRoutes::bytes_of(const Found& found, std::uint64_t tile) {
    constexpr int kMaxDepth = 4;
    const api::TileArchive& archive = found.archive;
    auto entries = directory(found, archive.root, 0, archive.root.length);
    for (int depth = 0; depth < kMaxDepth; ++depth) {
        if (!entries) return tl::unexpected(entries.error());
        const api::TileEntry* entry = api::find_entry(*entries, tile);
        if (entry == nullptr) return std::optional<std::string>();
        const auto [id, offset, length, run] = *entry;
        if (run > 0)
            return read(found, archive.tiles, offset, length).map([](std::string&& bytes) {
                return std::optional(std::move(bytes));
            });
        entries = directory(found, archive.leaves, offset, length);
    }
    return damaged();
}

HttpResult<Response> TileRoutes::tile(std::string_view path, const Request& request, const Connection& connection) {
    std::string name(path);
    std::ranges::replace(name, '/', '-');
    const std::string id(api::take_until(path, "/"));
    const auto place = parse_place(path);
    if (!place) return problem(404, "there is no such tile");
    const auto found = find(id, connection);
    if (!found) return tl::unexpected(found.error());
    const api::TileArchive& archive = found->archive;
    if (place->zoom < archive.min_zoom || place->zoom > archive.max_zoom)
        return problem(404, "the tiles have the zooms " + std::to_string(archive.min_zoom) + " to " +
                                std::to_string(archive.max_zoom));
    if (const auto tag = find_tag(request.header("If-None-Match"), name)) return not_modified(*tag);
    auto bytes = bytes_of(*found, api::tile_number(place->zoom, place->column, place->row));
    if (!bytes) return tl::unexpected(std::move(bytes.error()));
    Response response;
    allow_keeping(response);
    if (!*bytes) {
        response.status = 204;
        return response;
    }
    response.media_type = "application/vnd.mapbox-vector-tile";
    response.tag = '"' + name + '"';
    if (accepts_gzip(request.header("Accept-Encoding"))) {
        response.body = **std::move(bytes);
        response.coding = "gzip";
        return response;
    }
    auto plain = api::gunzipped(**bytes);
    if (!plain) return damaged();
    response.body = *std::move(plain);
    response.headers.push_back({"Vary", "Accept-Encoding"});
    return response;
}

HttpResult<Response> TileRoutes::document(const std::string& id, const Request& request, const Connection& connection) {
    const auto found = find(id, connection);
    if (!found) return tl::unexpected(found.error());
    const api::TileArchive& archive = found->archive;
    const auto bytes = read(*found, archive.metadata, 0, archive.metadata.length);
    if (!bytes) return tl::unexpected(bytes.error());
    const auto metadata = api::gunzipped(*bytes);
    if (!metadata || !metadata->starts_with('{')) return damaged();
    const Point middle = 0.5 * (archive.min + archive.max);
    Response response;
    response.media_type = "application/json";
    response.body = R"({"tilejson":"3.0.0","tiles":[)";
    api::append_json_text(response.body, origin_of(request) + "/tiles/" + id + "/{z}/{x}/{y}.mvt");
    response.body +=
        R"(],"minzoom":)" + std::to_string(archive.min_zoom) + R"(,"maxzoom":)" + std::to_string(archive.max_zoom) +
        R"(,"bounds":)" + numbers_of({archive.min.x, archive.min.y, archive.max.x, archive.max.y}) + R"(,"center":)" +
        numbers_of({middle.x, middle.y, static_cast<double>(archive.min_zoom)}) + ',' + metadata->substr(1) + '\n';
    return response;
}

}  // namespace ccdt::server
