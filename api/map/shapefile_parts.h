// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/result.h"

namespace ccdt::api {

/// Options for reading a zipped shapefile.
struct ShapefileReading {
    std::string_view object;    ///< name of the one that is read; empty: the only one
    std::size_t max_bytes = 0;  ///< of its files, inflated, and of the text that it becomes
};

/// Files of a shapefile, inflated. Those that it lacks are empty.
struct ShapefileParts {
    std::string shp;
    std::string shx;  ///< made from the .shp file: that in the archive may be missing or not fit
    std::string dbf;
    std::string cpg;
};

/// Inflates the files of a shapefile in a zip archive, and checks that each record lies within the .shp file.
///
/// Errors: those of ZipArchive; Unusable if there is no shapefile of that name or several to choose from, for a .shp
/// file that is damaged or truncated; LimitExceeded for more than `max_bytes`, PolygonInput::kMaxCorners or as many
/// records. The field is `object` or empty.
Result<ShapefileParts> read_parts(std::string_view archive, const ShapefileReading& reading);

/// Makes the error about a shapefile that is larger than it may be.
/// @param what  that is larger
tl::unexpected<Error> too_many_bytes(std::string_view what, std::size_t limit);

}  // namespace ccdt::api
