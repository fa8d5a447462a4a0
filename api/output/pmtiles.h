// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/point.h"

// Archives of tiles. Source: PMTiles Version 3 Specification, https://github.com/protomaps/PMTiles.

namespace ccdt::api {

/// Number of a tile among those of all zooms, which are numbered along Hilbert's curve.
/// @param zoom         at most 31
/// @param column, row  less than 2^zoom
std::uint64_t tile_number(int zoom, std::uint32_t column, std::uint32_t row);

/// A run of equal tiles in an archive, or a directory of tiles.
struct TileEntry {
    std::uint64_t id;      ///< number of the first tile
    std::uint64_t offset;  ///< in its section
    std::uint64_t length;
    std::uint64_t run;  ///< number of tiles; 0: the entry is a directory of the tiles from `id` on
};

/// The header of an archive.
struct TileArchive {
    static constexpr std::size_t kHeader = 127;  ///< bytes

    struct Section {
        std::uint64_t offset = 0, length = 0;
    };

    Section root, metadata, leaves, tiles;
    std::uint64_t entries = 0;
    int min_zoom = 0, max_zoom = 0;
    Point min, max;  ///< bounds in longitude and latitude, degrees
};

/// Writes the header of an archive of vector tiles that are compressed by gzip.
std::string write_header(const TileArchive& archive);

/// Reads what write_header() writes; none if it is something else.
std::optional<TileArchive> read_header(std::string_view bytes);

/// Writes a directory, compressed by gzip.
/// @param entries  in ascending order
std::string write_directory(std::span<const TileEntry> entries);

/// Reads what write_directory() writes; none if it is damaged.
std::optional<std::vector<TileEntry>> read_directory(std::string_view bytes);

/// Finds the entry of a tile, or of the directory that may have it; null if there is none.
const TileEntry* find_entry(std::span<const TileEntry> entries, std::uint64_t tile);

/// Compresses by gzip, without a name or a time.
std::string gzipped(std::string_view text);

/// Decompresses what gzipped() compressed; none if it is damaged.
std::optional<std::string> gunzipped(std::string_view bytes);

}  // namespace ccdt::api
