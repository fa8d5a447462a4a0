#pragma once

#include <string>
#include <string_view>

namespace ccdt::api {

/// Names of a format of files.
struct FileFormat {
    std::string_view name;        ///< of the option `format`
    std::string_view title;       ///< for people
    std::string_view extension;   ///< of file names
    std::string_view media_type;  ///< in Accept and Content-Type
    std::string_view parameters;  ///< after it in Content-Type

    std::string content_type() const { return std::string(media_type) += parameters; }
};

inline constexpr FileFormat kJson{"json", "JSON", "json", "application/json", ""};
inline constexpr FileFormat kCsv{"csv", "CSV", "csv", "text/csv", "; header=present"};
inline constexpr FileFormat kGeoJson{"geojson", "GeoJSON", "geojson", "application/geo+json", ""};
inline constexpr FileFormat kNpy{"npy", "NPY", "npy", "application/x-npy", ""};  // NumPy has registered none
inline constexpr FileFormat kSvg{"svg", "SVG", "svg", "image/svg+xml", ""};
inline constexpr FileFormat kPng{"png", "PNG", "png", "image/png", ""};
inline constexpr FileFormat kWebP{"webp", "WebP", "webp", "image/webp", ""};
inline constexpr FileFormat kTiff{"tiff", "TIFF", "tiff", "image/tiff", ""};

}  // namespace ccdt::api
