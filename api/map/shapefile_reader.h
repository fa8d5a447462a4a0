// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <string_view>

#include "api/map/shapefile_parts.h"
#include "core/base/result.h"

namespace ccdt::api {

/// First bytes of each zip archive that is not empty.
inline constexpr std::string_view kZipSignature = "PK\x03\x04";

/// Receives the next piece of a text.
/// @returns  false if the text has become too long for the receiver
using TakeText = std::function<bool(std::string_view piece)>;

/// Reads a zipped shapefile of polygons, and writes it as GeoJSON: a FeatureCollection with a Feature for each record,
/// with the properties in the .dbf file. Measures and heights are omitted. Coordinates are exactly those of the file.
/// The member `crs` names the reference system in the .prj file. Only the .shp file is required, and the .shx file is
/// not read.
///
/// The geometry of a record without a shape is null. Records that the .dbf file marks as deleted are omitted. Rings are
/// grouped by group_rings(). Numbers and logical values become numbers and booleans; dates become strings `YYYY-MM-DD`;
/// values of other types become strings. Empty values become null. The encoding of texts is named by the .cpg file, or
/// else by the language driver in the .dbf file. If it is unknown, fields with other characters than ASCII are left
/// out, as are fields of the same name. The member `unreadable` is then an object with the reason for each of these
/// fields.
///
/// Errors: Unusable if the archive is damaged or not a zipped shapefile of polygons, and if it has several shapefiles
/// and none is chosen; LimitExceeded for more than `max_bytes` bytes, and if the number of corners or of records
/// exceeds PolygonInput::kMaxCorners. Error::field is `object` or empty. Source: ESRI Shapefile Technical Description,
/// 1998.
Result<void> read_shapefile(std::string_view archive, const ShapefileReading& reading, const TakeText& take);

/// Estimates the peak memory of read_shapefile() in bytes, without the archive. At the peak, the function holds the
/// inflated files, and either the largest record with its corners and rings or the index of all records.
constexpr std::size_t shapefile_memory(std::size_t max_bytes) {
    constexpr std::size_t kBase = std::size_t{16} << 20;
    constexpr std::size_t kMaxOfCorners = std::size_t{96} << 20;
    return kBase + 2 * max_bytes + std::min(4 * max_bytes, kMaxOfCorners);
}

}  // namespace ccdt::api
