// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/output/pmtiles.h"
#include "server/http/connection.h"
#include "server/http/message.h"
#include "server/http/problem.h"
#include "server/jobs/job_service.h"
#include "server/jobs/result_reader.h"

namespace ccdt::server {

/// Answers requests for the tiles of jobs whose results are archives of tiles. Reads tiles by the directories of the
/// archive. Thread-safe.
class TileRoutes {
public:
    /// `jobs` and `results` must outlive this object.
    TileRoutes(JobService& jobs, ResultReader& results) : jobs_(jobs), results_(results) {}

    /// Answers with a tile, compressed if the client accepts this; with 204 if no dot lies in the tile.
    /// @param path  `job/zoom/column/row`
    HttpResult<Response> tile(std::string_view path, const Request& request, const Connection& connection);

    /// Answers with the TileJSON document of a job's tiles. Source: TileJSON 3.0.0,
    /// https://github.com/mapbox/tilejson-spec.
    HttpResult<Response> document(const std::string& id, const Request& request, const Connection& connection);

private:
    /// A job with tiles, and the header of its archive.
    struct Found {
        Job job;
        api::TileArchive archive;
    };

    HttpResult<Found> find(const std::string& id, const Connection& connection);
    HttpResult<std::string> read(const Found& found, const api::TileArchive::Section& section, std::uint64_t offset,
                                 std::uint64_t length);
    HttpResult<std::vector<api::TileEntry>> directory(const Found& found, const api::TileArchive::Section& section,
                                                      std::uint64_t offset, std::uint64_t length);
    HttpResult<std::optional<std::string>> bytes_of(const Found& found, std::uint64_t tile);

    JobService& jobs_;
    ResultReader& results_;
};

}  // namespace ccdt::server
