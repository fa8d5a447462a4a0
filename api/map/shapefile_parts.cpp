// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/shapefile_parts.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "api/input/option_reader.h"
#include "api/input/polygon_reader.h"
#include "api/map/zip_archive.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

tl::unexpected<Error> unusable(std::string message) {
    return failure(ErrorCode::Unusable, std::move(message));
}

std::string_view without_folders(std::string_view path) {
    return path.substr(path.find_last_of("/\\") + 1);
}

/// Returns the paths of all shapefiles in an archive, without the file extension. Ignores the files in which macOS
/// stores attributes.
std::vector<std::string> list_shapefiles(const ZipArchive& archive) {
    constexpr std::string_view kEnding = ".shp";
    std::vector<std::string> paths;
    for (const std::string& name : archive.names()) {
        const bool is_of_mac = name.starts_with("__MACOSX/") || without_folders(name).starts_with("._");
        if (in_small_letters(name).ends_with(kEnding) && !is_of_mac)
            paths.push_back(name.substr(0, name.size() - kEnding.size()));
    }
    return paths;
}

/// Chooses a shapefile by its path or its file name, without the extension.
Result<std::string> choose_shapefile(const ZipArchive& archive, std::string_view object) {
    const auto paths = list_shapefiles(archive);
    if (paths.empty())
        return unusable(
            "the archive contains no shapefile (.shp), and other files are read without an archive; its files are " +
            join_names(archive.names()));
    std::vector<std::string> chosen;
    std::ranges::copy_if(paths, std::back_inserter(chosen), [object](const std::string& path) {
        return object.empty() || path == object || without_folders(path) == object;
    });
    if (chosen.size() == 1) return chosen.front();
    if (chosen.empty())
        return failure(ErrorCode::Unusable,
                       "object: the archive contains no shapefile " + excerpt(object) + ", only " + join_names(paths),
                       "object");
    return failure(ErrorCode::Unusable,
                   "the archive contains several shapefiles: choose one of them with the option object (" +
                       join_names(chosen) + ")",
                   "object");
}

/// Inflates the file with the given path and extension. Letters may differ in case, unless a path has the same case.
/// Returns an empty text if there is no such file.
Result<std::string> read_part(const ZipArchive& archive, std::string_view path, std::string_view ending,
                              std::size_t& budget) {
    const auto& names = archive.names();
    const std::string wanted = in_small_letters(path) + std::string(ending);
    const auto is_wanted = [&](const std::string& name) { return in_small_letters(name) == wanted; };
    const auto is_same = [&](const std::string& name) { return name.starts_with(path) && is_wanted(name); };
    auto found = std::ranges::find_if(names, is_same);
    if (found == names.end()) found = std::ranges::find_if(names, is_wanted);
    if (found == names.end()) return std::string();
    return archive.read(static_cast<std::size_t>(found - names.begin()), budget);
}

constexpr std::size_t kHeaderSize = 100;
constexpr std::size_t kRecordHeaderSize = 8;

std::uint32_t number_at(std::string_view bytes, std::size_t at, std::endian order) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < sizeof(value); ++i) {
        const std::size_t next = order == std::endian::big ? i : sizeof(value) - 1 - i;
        value = value << 8 | static_cast<unsigned char>(bytes[at + next]);
    }
    return value;
}

void append_big_endian(std::string& out, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFF);
}

/// Returns the number of corners that a record declares, which may be more than it has. Returns 0 if the record is not
/// a polygon.
std::size_t count_corners(std::string_view content) {
    constexpr std::size_t kCountAt = 40;
    constexpr std::uint32_t kPolygonTypes[] = {5, 15, 25};
    if (content.size() < kCountAt + sizeof(std::uint32_t)) return 0;
    const bool is_polygon = std::ranges::count(kPolygonTypes, number_at(content, 0, std::endian::little)) > 0;
    return is_polygon ? number_at(content, kCountAt, std::endian::little) : 0;
}

tl::unexpected<Error> too_many(std::string_view what) {
    return failure(ErrorCode::LimitExceeded, "the shapefile has more than " +
                                                 std::to_string(PolygonInput::kMaxCorners) + ' ' + std::string(what) +
                                                 ", the limit");
}

/// Creates the .shx file. Its header is a copy of the header of the .shp file, with another length. After the header,
/// it has the offset and the length of each record in the .shp file, in words of 16 bits.
Result<std::string> make_index(std::string_view shp) {
    constexpr std::uint32_t kFileCode = 9994;
    constexpr std::size_t kLengthAt = 24;
    if (shp.size() < kHeaderSize || number_at(shp, 0, std::endian::big) != kFileCode)
        return unusable("the .shp file does not begin with the signature of a shapefile");
    const std::size_t end = std::size_t{2} * number_at(shp, kLengthAt, std::endian::big);
    if (end < kHeaderSize || end > shp.size()) return unusable("the .shp file is truncated");
    std::string index(shp.substr(0, kHeaderSize));
    std::size_t count = 0;
    std::size_t corners = 0;
    for (std::size_t at = kHeaderSize; at < end; ++count) {
        if (count == PolygonInput::kMaxCorners) return too_many("records");
        const bool has_header = end - at >= kRecordHeaderSize;
        const std::uint32_t words = has_header ? number_at(shp, at + 4, std::endian::big) : 0;
        const std::size_t size = std::size_t{2} * words;
        if (words < 2 || size > end - at - kRecordHeaderSize)
            return unusable("the .shp file ends within record " + std::to_string(count + 1));
        corners += count_corners(shp.substr(at + kRecordHeaderSize, size));
        if (corners > PolygonInput::kMaxCorners) return too_many("corners");
        append_big_endian(index, static_cast<std::uint32_t>(at / 2));
        append_big_endian(index, words);
        at += kRecordHeaderSize + size;
    }
    std::string length;
    append_big_endian(length, static_cast<std::uint32_t>(index.size() / 2));
    return index.replace(kLengthAt, length.size(), length);
}

}  // namespace

Result<ShapefileParts> read_parts(std::string_view bytes, const ShapefileReading& reading) {
    const auto archive = ZipArchive::open(bytes);
    if (!archive) return tl::unexpected(archive.error());
    const auto path = choose_shapefile(*archive, reading.object);
    if (!path) return tl::unexpected(path.error());
    ShapefileParts parts;
    std::size_t budget = reading.max_bytes;
    for (const auto& [ending, part] : {std::pair(".shp", &ShapefileParts::shp),
                                       {".dbf", &ShapefileParts::dbf},
                                       {".cpg", &ShapefileParts::cpg},
                                       {".prj", &ShapefileParts::prj}}) {
        auto read = read_part(*archive, *path, ending, budget);
        if (!read && read.error().code == ErrorCode::LimitExceeded)
            return too_many_bytes("the inflated files of the shapefile are larger", reading.max_bytes);
        if (!read) return tl::unexpected(read.error());
        parts.*part = *std::move(read);
    }
    return make_index(parts.shp).map([&](std::string&& index) {
        parts.shx = std::move(index);
        return std::move(parts);
    });
}

tl::unexpected<Error> too_many_bytes(std::string_view what, std::size_t limit) {
    return failure(ErrorCode::LimitExceeded, std::string(what) + " than " + std::to_string(limit) +
                                                 " bytes, this server's limit (max-body, memory)");
}

}  // namespace ccdt::api
