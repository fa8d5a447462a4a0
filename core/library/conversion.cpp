// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/library/conversion.h"

#include <charconv>
#include <cmath>
#include <thread>
#include <variant>

namespace ccdt::v2 {
namespace {

FailureCode code_of(ccdt::ErrorCode code) {
    switch (code) {
        case ccdt::ErrorCode::Malformed:
            return FailureCode::Malformed;
        case ccdt::ErrorCode::Unusable:
            return FailureCode::Unusable;
        case ccdt::ErrorCode::LimitExceeded:
            return FailureCode::LimitExceeded;
        case ccdt::ErrorCode::NotAcceptable:
            return FailureCode::NotAcceptable;
        case ccdt::ErrorCode::Unsupported:
            return FailureCode::Unsupported;
        case ccdt::ErrorCode::Unavailable:
            return FailureCode::Unavailable;
        case ccdt::ErrorCode::Stopped:
            return FailureCode::Stopped;
        case ccdt::ErrorCode::Internal:
            break;
    }
    return FailureCode::Internal;
}

std::string shortest(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

void check_side(double side, const char* name) {
    if (side > 0 && std::isfinite(side)) return;
    raise(FailureCode::Malformed,
          std::string(name) + " is " + shortest(side) + ", but must be a positive and finite number", name);
}

/// Converts polygons without checks. Domain::create() and Domain::repair() check them.
std::vector<ccdt::PolygonPart> parts_of(std::span<const Polygon> polygons) {
    const auto ring_of = [](const Ring& ring) {
        ccdt::Ring corners;
        corners.reserve(ring.size());
        for (const Point& corner : ring) corners.push_back({corner.x, corner.y});
        return corners;
    };
    std::vector<ccdt::PolygonPart> parts;
    for (const Polygon& polygon : polygons) {
        ccdt::PolygonPart& part = parts.emplace_back();
        part.outer = ring_of(polygon.outer);
        for (const Ring& hole : polygon.holes) part.holes.push_back(ring_of(hole));
    }
    return parts;
}

/// Builds the domain of each alternative of Domain.
class DomainMaker {
public:
    DomainMaker(bool repair, const std::stop_token& stop) : repair_(repair), stop_(stop) {}

    ccdt::Result<ccdt::RepairedDomain> operator()(const Polygon& polygon) const {
        return make(parts_of({&polygon, 1}));
    }
    ccdt::Result<ccdt::RepairedDomain> operator()(const std::vector<Polygon>& polygons) const {
        return make(parts_of(polygons));
    }
    ccdt::Result<ccdt::RepairedDomain> operator()(const Rectangle& rectangle) const {
        check(rectangle.width, rectangle.height);
        return ccdt::Domain::rectangle(rectangle.width, rectangle.height).map(valid);
    }
    ccdt::Result<ccdt::RepairedDomain> operator()(const Torus& torus) const {
        check(torus.width, torus.height);
        return ccdt::Domain::torus(torus.width, torus.height).map(valid);
    }

private:
    static void check(double width, double height) {
        check_side(width, "width");
        check_side(height, "height");
    }

    static ccdt::RepairedDomain valid(ccdt::Domain&& domain) { return {std::move(domain), {}}; }

    ccdt::Result<ccdt::RepairedDomain> make(const std::vector<ccdt::PolygonPart>& parts) const {
        return repair_ ? ccdt::Domain::repair(parts, stop_) : ccdt::Domain::create(parts, stop_).map(valid);
    }

    bool repair_;
    const std::stop_token& stop_;
};

std::size_t threads_of(const Control& control) {
    return control.threads > 0 ? control.threads : std::thread::hardware_concurrency();
}

}  // namespace

void raise(const ccdt::Error& error) {
    std::string message = error.message;
    for (const ccdt::Error& other : error.others) message.append("; ").append(other.message);
    raise(code_of(error.code), message, error.field);
}

void raise(FailureCode code, const std::string& message, std::string field) {
    throw Exception(code, message, std::move(field));
}

void check_range(double value, double min, double max, const char* name) {
    if (value >= min && value <= max) return;
    raise(FailureCode::Malformed,
          std::string(name) + " is " + shortest(value) + ", but must be from " + shortest(min) + " to " + shortest(max),
          name);
}

Execution::Execution(const Control& control) : executor_(threads_of(control)), control_{control.stop, {}, &executor_} {
    if (!control.progress) return;
    control_.progress = [call = control.progress](const ccdt::Progress& progress) {
        call({progress.done(), progress.variation.value_or(0)});
    };
}

void Execution::check_stop() const {
    if (control_.stop.stop_requested()) raise(FailureCode::Stopped, "the computation was stopped", "");
}

std::vector<Point> points_of(std::span<const ccdt::Point> points) {
    std::vector<Point> converted;
    converted.reserve(points.size());
    for (const ccdt::Point& point : points) converted.push_back({point.x, point.y});
    return converted;
}

std::vector<ccdt::Point> core_points(std::span<const Point> points, std::string_view field) {
    std::vector<ccdt::Point> converted;
    converted.reserve(points.size());
    for (const Point& point : points) {
        if (!std::isfinite(point.x) || !std::isfinite(point.y)) {
            const std::string number = std::to_string(converted.size());
            raise(FailureCode::Malformed,
                  "point " + number + " of " + std::string(field) + " has the coordinates " + shortest(point.x) +
                      " and " + shortest(point.y) + ", which must be finite",
                  std::string(field) + '/' + number);
        }
        converted.push_back({point.x, point.y});
    }
    return converted;
}

ccdt::Quality core_quality(Quality quality) {
    switch (quality) {
        case Quality::Draft:
            return ccdt::Quality::Draft;
        case Quality::Standard:
            return ccdt::Quality::Standard;
        case Quality::Best:
            return ccdt::Quality::Best;
        case Quality::Stealthy:
            return ccdt::Quality::Stealthy;
    }
    raise(FailureCode::Malformed, "quality is not one of the enumerators", "quality");
}

ccdt::RepairedDomain make_domain(const Domain& domain, bool repair, const std::stop_token& stop) {
    return value_of(std::visit(DomainMaker(repair, stop), domain));
}

}  // namespace ccdt::v2
