// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <string>

#include "api/input/polygon_reader.h"
#include "api/map/shapefile_reader.h"
#include "tests/fuzz/checks.h"
#include "tests/support/shapefiles.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxBytes = 65'536;

/// Checks that an archive is converted to valid GeoJSON or refused with a valid error.
void check_archive(const std::string& archive) {
    std::string text;
    const auto take = [&text](std::string_view piece) {
        text += piece;
        return true;
    };
    if (const auto read = api::read_shapefile(archive, {{}, kMaxBytes}, take); !read) {
        check_error(read.error());
        return;
    }
    CCDT_CHECK(text.size() <= kMaxBytes);
    check_json(text);
    const auto document = api::JsonDocument::parse(text);
    CCDT_CHECK(document && api::is_geojson(document->root()));
    const auto polygon = api::read_geometry({"the body", "", document->root()});
    CCDT_CHECK(polygon || polygon.error().message == "the body contains no polygon");
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads a shapefile. The input is a zip archive, or the files of an archive: a 16-bit size, a .shp file of this size,
/// and a .dbf file. In the second form, mutations do not invalidate checksums.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const std::string input(fuzz::text_of(data, size));
    if (input.starts_with(api::kZipSignature)) {
        fuzz::check_archive(input);
    } else if (size >= 2) {
        const std::size_t end = 2 + (data[0] | std::size_t{data[1]} << 8);
        const std::string shp = input.substr(2, end - 2);
        const std::string dbf = input.substr(std::min(end, size));
        fuzz::check_archive(zip_of({{"a.shp", shp}, {"a.dbf", dbf}, {"a.cpg", "ISO-8859-1"}}));
    }
    return 0;
}
