// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace ccdt::api {

/// Names of a file format.
struct FileFormat {
    std::string_view name;        ///< value of the option `format`
    std::string_view title;       ///< name shown to users
    std::string_view extension;   ///< extension of file names
    std::string_view media_type;  ///< media type in Accept and Content-Type
    std::string_view parameters;  ///< appended to the media type in Content-Type

    std::string content_type() const { return std::string(media_type) += parameters; }
};

// Formats that several tables have. All other formats are defined beside their table.
inline constexpr FileFormat kJson{"json", "JSON", "json", "application/json", ""};
inline constexpr FileFormat kSvg{"svg", "SVG", "svg", "image/svg+xml", ""};
inline constexpr FileFormat kPng{"png", "PNG", "png", "image/png", ""};
inline constexpr FileFormat kCsv{"csv", "CSV", "csv", "text/csv", "; header=present"};
inline constexpr FileFormat kNpy{"npy", "NPY", "npy", "application/x-npy", ""};  ///< no registered media type
inline constexpr FileFormat kGeoJson{"geojson", "GeoJSON", "geojson", "application/geo+json", ""};
// The media type is in common use, but not registered.
inline constexpr FileFormat kGeoJsonLines{"ndjson", "GeoJSON, a Feature per line", "ndjson", "application/x-ndjson",
                                          ""};
inline constexpr FileFormat kGeoJsonSequence{"geojsonseq", "GeoJSON text sequence", "geojsons",
                                             "application/geo+json-seq", ""};
inline constexpr FileFormat kPly{"ply", "PLY", "ply", "model/ply", ""};  ///< common, but not registered

}  // namespace ccdt::api
