// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/text/file_kind.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "api/text/byte_order_mark.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kBlanks = " \t\r\n";

/// A kind of files. A file is of this kind if it contains `mark` at `offset`.
struct Kind {
    std::size_t offset;
    std::string_view mark;
    std::string_view name;
};

constexpr Kind kKinds[] = {
    {0, "\x89PNG"sv, "a damaged PNG"},
    {4, "ftypcrx "sv, "a camera's raw file"},
    {4, "ftypmif3"sv, "a HEIF or AVIF with minimized properties (mif3)"},
    {4, "ftyp"sv, "a video"},
    {4, "JXL "sv, "JPEG XL"},
    {0, "\xff\x0a"sv, "JPEG XL"},
    {4, "jP  "sv, "JPEG 2000"},
    {0, "\xff\x4f\xff\x51"sv, "JPEG 2000"},
    {0, "8BPS"sv, "a Photoshop file"},
    {0, "%PDF"sv, "PDF"},
    {0, "%!PS"sv, "PostScript"},
    {0, "\0\0\1\0"sv, "an icon"},
    {0, "\0\0\2\0\1"sv, "a cursor"},
    {0, "\x76\x2f\x31\x01"sv, "OpenEXR"},
    {0, "#?RADIANCE"sv, "Radiance HDR"},
    {0, "P4\n"sv, "PBM"},
    {0, "P5\n"sv, "PGM"},
    {0, "P6\n"sv, "PPM"},
    {0, "P7\n"sv, "PAM"},
    {0, "PF\n"sv, "PFM"},
    {0, "DDS "sv, "DDS"},
    {0, "qoif"sv, "QOI"},
    {0, "PK\3\4"sv, "a ZIP archive"},
    {0, "PK\5\6"sv, "an empty ZIP archive"},
    {0, "\x1f\x8b"sv, "gzip"},
    {0, "BZh"sv, "bzip2"},
    {0,
     "\xfd"
     "7zXZ"sv,
     "an XZ archive"},
    {0, "\x28\xb5\x2f\xfd"sv, "a Zstandard file"},
    {0, "7z\xbc\xaf\x27\x1c"sv, "a 7-Zip archive"},
    {0, "Rar!"sv, "a RAR archive"},
    {257, "ustar"sv, "a tar archive"},
    {0, "\0\0\x27\x0a"sv, "a .shp or .shx file, which is read in a zip archive with the other files of the shapefile"},
    {68, "GPKG"sv, "a GeoPackage"},
    {68, "GP1"sv, "a GeoPackage"},
    {0, "SQLite format 3\0"sv, "an SQLite database"},
    {0, "fgb\3fgb"sv, "FlatGeobuf"},
    {0, "PAR1"sv, "Parquet, such as GeoParquet"},
    {0, "ARROW1"sv, "Arrow"},
    {0, "PMTiles"sv, "PMTiles"},
    {0, "\x89HDF"sv, "HDF5"},
    {0, "CDF\1"sv, "NetCDF"},
    {0, "CDF\2"sv, "NetCDF"},
    {0, "LASF"sv, "LAS"},
    {128, "DICM"sv, "DICOM"},
    {0, "Kaydara FBX"sv, "FBX"},
    {0, "BLENDER"sv, "a Blender file"},
    {0, "ISO-10303-21"sv, "STEP"},
    {0, "#VRML"sv, "VRML"},
    {0, "# vtk DataFile"sv, "VTK"},
    {0, "$MeshFormat"sv, "a mesh of Gmsh"},
    {0, "# .PCD"sv, "PCD"},
    {0, "AC10"sv, "DWG"},
    {0, "#usda"sv, "USD"},
    {0, "PXR-USDC"sv, "USD"},
    {0, "ASTM-E57"sv, "E57"},
    {6, "OSMHeader"sv, "a file of OpenStreetMap"},
    {0, "\xff\xfe\0\0"sv, "text in UTF-32, not in UTF-8"},
    {0, "\xff\xfe"sv, "text in UTF-16, not in UTF-8"},
    {0, "\xfe\xff"sv, "text in UTF-16, not in UTF-8"},
};

struct Element {
    std::string_view mark;
    std::string_view name;
};

/// Root elements of XML, in small letters.
constexpr auto kElements = std::to_array<Element>({
    {"<kml", "KML"},
    {"<gpx", "GPX"},
    {"<osm", "a file of OpenStreetMap"},
    {"<svg", "SVG"},
    {"<html", "HTML"},
    {"<!doctype html", "HTML"},
    {"<collada", "COLLADA"},
    {"<x3d", "X3D"},
    {"<vtkfile", "VTK"},
    {"<gml:", "GML"},
    {"<wfs:", "GML"},
    {"<ogr:", "GML"},
    {"<featurecollection", "GML"},
});

/// Types of geometries in well-known text, in small letters.
constexpr auto kWellKnown = std::to_array<std::string_view>(
    {"polygon", "multipolygon", "point", "multipoint", "linestring", "multilinestring", "geometrycollection"});

/// Whether a file is a table of dBASE: version, date of the last change, and lengths of the header and the records.
bool is_dbf(std::string_view bytes) {
    constexpr std::size_t kHeader = 32;
    constexpr std::string_view kVersions = "\x03\x30\x31\x32\x83\x8b\xf5";
    if (bytes.size() <= kHeader || kVersions.find(bytes[0]) == std::string_view::npos) return false;
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    return byte(2) >= 1 && byte(2) <= 12 && byte(3) >= 1 && byte(3) <= 31 && byte(8) + 256U * byte(9) > kHeader;
}

/// Whether a file is well-known binary, or begins like it in hexadecimal digits: the byte order and the type of the
/// geometry, 1 to 7, perhaps with flags or a multiple of 1000.
bool is_wkb(std::string_view bytes) {
    constexpr std::size_t kHead = 5;
    constexpr std::string_view kDigits = "0123456789abcdefABCDEF";
    std::array<unsigned, kHead> head{};
    const bool is_hexadecimal = bytes.size() >= 2 * kHead && bytes.find_first_not_of(kDigits) >= 2 * kHead;
    if (!is_hexadecimal && bytes.size() < kHead) return false;
    for (std::size_t i = 0; i < kHead; ++i)
        head[i] = is_hexadecimal ? parse_number<unsigned>(bytes.substr(2 * i, 2), 16).value_or(0)
                                 : static_cast<unsigned char>(bytes[i]);
    if (head[0] > 1) return false;
    if (head[0] == 0) std::reverse(head.begin() + 1, head.end());
    const unsigned type = head[1] + 256 * head[2], base = type % 1000;
    return base >= 1 && base <= 7 && type < 4000 && head[3] == 0 && (head[4] & 0x1F) == 0;
}

/// Returns the kind whose root element comes first.
std::string_view kind_of_xml(std::string_view text) {
    constexpr std::size_t kSearched = 4096;
    const std::string small = in_small_letters(text.substr(0, kSearched));
    const auto position = [&](const Element& element) { return small.find(element.mark); };
    const Element& first = *std::ranges::min_element(kElements, {}, position);
    return position(first) == std::string::npos ? "XML" : first.name;
}

/// Whether a text has the same separator at least once in each of its first two lines.
bool is_table(std::string_view text) {
    constexpr std::size_t kSearched = 65536;  // a map may be a single line
    text = text.substr(0, kSearched);
    const std::string_view first = take_until(text, "\n"), second = take_until(text, "\n");
    return std::ranges::any_of(",;\t"sv, [&](char separator) {
        const auto count = std::ranges::count(first, separator);
        return count > 0 && count == std::ranges::count(second, separator);
    });
}

std::string_view kind_of_text(std::string_view text) {
    text = trim(without_byte_order_mark(text), kBlanks);
    if (text.starts_with('<')) return kind_of_xml(text);
    const std::string word = in_small_letters(text.substr(0, text.find_first_of(" \t\r\n([")));
    if (std::ranges::count(kWellKnown, word) > 0 || word.starts_with("srid=")) return "well-known text (WKT)";
    if (word == "geogcs" || word == "projcs" || word == "geogcrs" || word == "projcrs")
        return "a .prj file, which is read in a zip archive with the other files of the shapefile";
    if (word == "newmtl") return "the materials of an OBJ (MTL), without its mesh";
    if (word == "0" && trim(text.substr(1), kBlanks).starts_with("SECTION")) return "DXF";
    return is_table(text) ? "CSV" : "text";
}

}  // namespace

bool is_text(std::string_view bytes) {
    constexpr std::size_t kSearched = 1024;
    return std::ranges::all_of(bytes.substr(0, kSearched), [](char c) {
        return static_cast<unsigned char>(c) >= ' ' || kBlanks.find(c) != std::string_view::npos || c == '\f';
    });
}

std::string_view kind_of_file(std::string_view bytes) {
    if (trim(without_byte_order_mark(bytes), kBlanks).empty()) return "empty";
    const Kind* const kind = std::ranges::find_if(kKinds, [&](const Kind& each) {
        return bytes.size() > each.offset && bytes.substr(each.offset).starts_with(each.mark);
    });
    if (kind != std::end(kKinds)) return kind->name;
    if (is_dbf(bytes)) return "a .dbf file, which is read in a zip archive with the other files of the shapefile";
    if (is_wkb(bytes)) return "well-known binary (WKB)";
    for (const std::size_t low : {std::size_t{0}, std::size_t{1}}) {
        if (bytes.size() > 3 && bytes[1 - low] == '\0' && bytes[3 - low] == '\0' && is_text(bytes.substr(low, 1)) &&
            is_text(bytes.substr(low + 2, 1)))
            return "text in UTF-16, not in UTF-8";
    }
    return is_text(bytes) ? kind_of_text(bytes) : std::string_view();
}

}  // namespace ccdt::api
