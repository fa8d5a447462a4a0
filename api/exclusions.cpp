#include "api/exclusions.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "core/geometry/difference.h"
#include "core/globe/region.h"
#include "core/globe/turns.h"

namespace ccdt::api {
namespace {

constexpr const char* kAvoid = "/avoid";

/// Copies of an area in all turns of the globe in which it may meet a box.
std::vector<Area> in_turns_of(const Box& box, const Area& area) {
    constexpr double kFar = std::numeric_limits<double>::max();
    double west = kFar, east = -kFar;
    for (const Ring& ring : area) {
        for (const Point& p : ring) {
            west = std::min(west, p.x);
            east = std::max(east, p.x);
        }
    }
    std::vector<Area> copies;
    for (double turn = std::ceil((box.min.x - east) / kTurn); west + turn * kTurn <= box.max.x; ++turn) {
        Area& copy = copies.emplace_back(area);
        for (Ring& ring : copy) {
            for (Point& p : ring) p.x += turn * kTurn;
        }
    }
    return copies;
}

/// Makes an error about what is avoided one about the request.
Error located(Error error, const PolygonInput& avoid) {
    error.field = avoid.locate(error.field);
    if (error.field.empty()) error.field = kAvoid;
    return error;
}

/// Finds out what the polygons to be avoided cover. Fields of the repairs are JSON Pointers in the request.
Result<RepairedArea> avoided_area(const SampleRequest& request, const std::stop_token& stop) {
    const PolygonInput& avoid = request.avoid;
    const bool is_plane = request.coordinates == Coordinates::Plane;
    const auto parts = is_plane ? Result<std::vector<PolygonPart>>(avoid.parts) : unrolled(avoid.parts);
    if (!parts) return tl::unexpected(located(parts.error(), avoid));
    auto area = Domain::repair_area(*parts, stop);
    if (!area) return tl::unexpected(located(area.error(), avoid));
    for (Repair& repair : area->repairs) repair.field = avoid.locate(repair.field);
    if (area->repairs.empty() || request.on_invalid == OnInvalid::Repair) return area;
    return failure(ErrorCode::Unusable, area->repairs.front().detail, area->repairs.front().field);
}

}  // namespace

Result<RepairedDomain> without_exclusions(RepairedDomain area, const SampleRequest& request,
                                          const std::stop_token& stop) {
    if (request.avoid.parts.empty()) return area;
    auto avoided = avoided_area(request, stop);
    if (!avoided) return tl::unexpected(avoided.error());
    const std::vector<Area> areas = request.coordinates == Coordinates::Plane
                                        ? std::vector<Area>{std::move(avoided->rings)}
                                        : in_turns_of(area.domain.bounds(), avoided->rings);
    auto left = without(area.domain, areas, stop);
    if (!left) return failure(left.error().code, left.error().message, kAvoid);
    std::ranges::move(avoided->repairs, std::back_inserter(area.repairs));
    return RepairedDomain{*std::move(left), std::move(area.repairs)};
}

}  // namespace ccdt::api
