// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/output/json_writer.h"
#include "api/run/deadline.h"
#include "api/sample/density_input.h"
#include "api/table/point_table.h"
#include "core/geometry/point3.h"
#include "core/points/choice/choice.h"

namespace ccdt::api {

struct ChoiceFormat;

/// Request to /sample with candidates: an exact number of given points.
struct ChoiceRequest {
    std::vector<Point3> candidates;  ///< as given; z is 0 in the plane
    choice::Extent extent = choice::Extent::Plane;
    bool is_on_globe = false;  ///< whether candidates are longitudes and latitudes
    std::size_t sites = 0;     ///< without a spacing
    std::optional<double>
        spacing;  ///< least distance of chosen points, in units of the candidates or, on the globe, metres
    std::vector<double> density, priority;  ///< [candidates] or empty
    DensityInput density_map;               ///< density over the bounding box of the candidates, instead of a list
    std::vector<std::uint8_t> kept;         ///< [candidates] or empty
    std::vector<std::uint32_t> classes;     ///< [candidates] or empty
    std::vector<std::size_t> counts;        ///< number of points of each class; empty: in proportion to the candidates
    std::uint64_t seed = 0;
    bool is_progressive = false;           ///< whether the chosen candidates are ordered progressively
    const ChoiceFormat* format = nullptr;  ///< never null in a parsed request
    OnStop on_deadline = OnStop::Error;    ///< a partial answer is spread less evenly
    std::vector<Warning> warnings;

    // Of a file with the candidates:
    bool is_file = false;
    std::string file;  ///< if records of it are the answer; otherwise empty
    PointTable table;  ///< places of the records; without positions and columns
};

}  // namespace ccdt::api
