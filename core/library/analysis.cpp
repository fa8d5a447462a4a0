// SPDX-License-Identifier: GPL-3.0-or-later
#include "ccdt/analysis.h"

#include <string>
#include <utility>

#include "core/library/conversion.h"
#include "core/points/analysis/analysis.h"

namespace ccdt::v2 {

namespace {

PointAnalysis result_of(ccdt::Result<ccdt::Analysis> measured) {
    if (!measured) {
        ccdt::Error& error = measured.error();
        if (error.field.starts_with('/')) error.field.insert(0, "sets");
        raise(error);
    }
    auto& spectrum = measured->spectrum;
    return {measured->sets,
            measured->points,
            measured->unit,
            std::move(measured->frequency),
            std::move(measured->power),
            std::move(measured->anisotropy_db),
            measured->low_frequency_power,
            measured->min_distance,
            measured->mean_distance,
            {spectrum.width, spectrum.height, std::move(spectrum.values)}};
}

}  // namespace

PointAnalysis analyze(std::span<const std::vector<Point>> sets, const Domain& domain, double max_frequency,
                      const Control& control) {
    if (!std::holds_alternative<Rectangle>(domain) && !std::holds_alternative<Torus>(domain))
        raise(FailureCode::Malformed, "the domain of an analysis must be a Rectangle or a Torus", "domain");
    check_range(max_frequency, 1, 16, "max_frequency");
    const auto made = make_domain(domain, false, control.stop).domain;
    std::vector<std::vector<ccdt::Point>> given;
    for (const auto& set : sets) given.push_back(core_points(set, "sets/" + std::to_string(given.size())));
    return result_of(ccdt::analyse(given, made, {max_frequency}, control.stop));
}

PointAnalysis analyze(std::span<const std::vector<Point3>> sets, const VolumeDomain& domain, double max_frequency,
                      const Control& control) {
    if (std::holds_alternative<Solid>(domain))
        raise(FailureCode::Malformed, "the domain of an analysis in space must be a Box3 or a Torus3", "domain");
    check_range(max_frequency, 1, 16, "max_frequency");
    const auto* const torus = std::get_if<Torus3>(&domain);
    const Box3 box = torus != nullptr ? Box3{torus->width, torus->height, torus->depth} : std::get<Box3>(domain);
    std::vector<std::vector<ccdt::Point3>> given;
    for (const auto& set : sets) given.push_back(converted<ccdt::Point3>(set));
    return result_of(
        ccdt::analyse(given, {box.width, box.height, box.depth}, torus != nullptr, {max_frequency}, control.stop));
}

PointAnalysis analyze(const std::vector<Point>& points, const Domain& domain, double max_frequency,
                      const Control& control) {
    return analyze(std::span(&points, 1), domain, max_frequency, control);
}

PointAnalysis analyze(const std::vector<Point3>& points, const VolumeDomain& domain, double max_frequency,
                      const Control& control) {
    return analyze(std::span(&points, 1), domain, max_frequency, control);
}

}  // namespace ccdt::v2
