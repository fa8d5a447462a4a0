// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/polygon_reader.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/shape_checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxCorners = 64;  ///< maximum for which points are distributed
constexpr std::size_t kSites = 12;

void check_polygon(const api::PolygonInput& polygon, std::string_view body) {
    CCDT_CHECK(!polygon.parts.empty());
    const auto domain = Domain::create(polygon.parts);
    if (!domain) {
        check_location(domain.error(), polygon.parts);
        Error error = domain.error();
        error.field = polygon.pointer_to(error.field);
        check_error(error, body);
        return;
    }
    check_domain(*domain);
    if (polygon.corner_count() > kMaxCorners) return;
    Options options;
    options.sites = kSites;
    options.iterations = 1;
    options.passes = 2;
    check_distribution(*domain, polygon.parts, Density::uniform(), options);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as the GeoJSON member `geometry` of a request to /sample, and distributes points in the polygons.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto body = fuzz::text_of(data, size);
    const auto document = api::JsonDocument::parse(body);
    if (!document) return 0;
    const auto polygon = api::read_geometry({"", "", document->root()});
    if (!polygon) {
        fuzz::check_error(polygon.error(), body);
        return 0;
    }
    CCDT_CHECK(api::check_size(*polygon));
    fuzz::check_polygon(*polygon, body);
    return 0;
}
