// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string_view>

#include "api/map/shapefile_parts.h"
#include "core/result.h"

namespace ccdt::api {

/// First bytes of a zip archive that holds anything.
inline constexpr std::string_view kZipSignature = "PK\x03\x04";

/// Takes the next piece of a text.
/// @returns  false if there is no room for it
using TakeText = std::function<bool(std::string_view piece)>;

/// Reads a zipped shapefile of polygons, and writes it as GeoJSON: a FeatureCollection with a Feature for each record,
/// whose properties are those of the .dbf file. Measures and heights are left out. Coordinates are those of the file,
/// to the last bit; the .prj file is not read. The .shx file is not needed, nor is the .dbf file.
///
/// Features without a shape have the geometry null; records that the .dbf file marks as deleted are left out. Rings are
/// grouped by group_rings(). Numbers become numbers, logical values booleans, dates texts `YYYY-MM-DD`, everything else
/// text; empty values are null. The .cpg file, else the .dbf file's language driver, names the encoding of texts.
///
/// Errors: Unusable for what is no zipped shapefile of polygons, or a damaged one, for several of which none is chosen,
/// and for texts in an encoding that is not read; LimitExceeded for more than `max_bytes`, PolygonInput::kMaxCorners or
/// as many records. The field is `object` or empty.
/// Source: ESRI Shapefile Technical Description, 1998.
Result<void> read_shapefile(std::string_view archive, const ShapefileReading& reading, const TakeText& take);

/// Estimates the peak memory of read_shapefile() besides the archive: the inflated files, the largest record, and its
/// corners and rings, or the index of all records.
constexpr std::size_t shapefile_memory(std::size_t max_bytes) {
    constexpr std::size_t kBase = std::size_t{16} << 20;
    constexpr std::size_t kMostOfCorners = std::size_t{96} << 20;
    return kBase + 2 * max_bytes + std::min(4 * max_bytes, kMostOfCorners);
}

}  // namespace ccdt::api
