// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace ccdt::api {

/// Options for reading a zipped shapefile.
struct ShapefileReading {
    /// Path or file name of the shapefile to read, without the extension. Empty: the only shapefile.
    std::string_view object;
    std::size_t max_bytes = 0;  ///< maximum size of the inflated files, and also of the GeoJSON text
};

/// Inflated files of a shapefile. Missing files are empty.
struct ShapefileParts {
    std::string shp;
    std::string shx;  ///< created from the .shp file, since the one in the archive may be missing or inconsistent
    std::string dbf;
    std::string cpg;
    std::string prj;
};

/// Inflates the files of a shapefile in a zip archive, and checks that each record lies within the .shp file.
///
/// Errors: those of ZipArchive; Unusable unless exactly one shapefile of the archive matches `object`, and for a .shp
/// file that is damaged or truncated; LimitExceeded for more than `max_bytes` bytes, and if the number of corners or of
/// records exceeds PolygonInput::kMaxCorners. Error::field is `object` or empty.
Result<ShapefileParts> read_parts(std::string_view archive, const ShapefileReading& reading);

/// Returns the error of a shapefile that exceeds the limit on its size.
/// @param what  the subject and the verb of the message, such as "the files are larger"
tl::unexpected<Error> too_many_bytes(std::string_view what, std::size_t limit);

}  // namespace ccdt::api
