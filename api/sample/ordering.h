// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <numeric>
#include <span>
#include <stop_token>

#include "api/sample/sample_request.h"
#include "core/base/result.h"
#include "core/ccdt/maps/dot_map.h"
#include "core/geometry/domain.h"
#include "core/points/order/reorder.h"

namespace ccdt::api {

/// Puts points into the order that a request asks for. Points that are grouped by features stay grouped: each group has
/// its own path. A progressive order is computed for all points together; it gives each point a rank, and the points of
/// each group are sorted by rank. Does nothing for paths in drawings of shapes, whose writers find the paths.
/// Errors: Stopped, unless the request accepts partial results. After a stop, the order is arbitrary.
Result<void> order_points(const SampleRequest& request, const Domain& whole, ClassDots& dots, const Control& control);

/// Puts points on a surface or in space into a progressive order, and sets their ranks.
/// @param order  result of progressive_order_on_surface() or progressive_order_in_space()
template <class AnyDistribution>
void set_order(AnyDistribution& dots, std::span<const std::uint32_t> order, const std::stop_token& stop) {
    reorder(dots, order);
    dots.ranks.resize(dots.points.size());
    std::iota(dots.ranks.begin(), dots.ranks.end(), std::uint32_t{0});
    dots.stopped = dots.stopped || stop.stop_requested();
}

}  // namespace ccdt::api
