// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/ordering.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "api/output/point_set.h"
#include "api/run/deadline.h"
#include "core/points/order/progressive_order.h"
#include "core/points/order/reorder.h"
#include "core/points/tour/short_path.h"

namespace ccdt::api {
namespace {

/// Returns the order to establish before writing: the requested order, except for paths in drawings of shapes, whose
/// writers find the paths.
PointOrder order_of(const SampleRequest& request) {
    const PointOrder order = request.output.order.value_or(PointOrder::None);
    const bool is_vector = std::holds_alternative<VectorWriter>(request.output.format->writer);
    return order == PointOrder::Path && is_vector ? PointOrder::None : order;
}

bool is_uniform(const SampleRequest& request) {
    return std::holds_alternative<std::monostate>(request.density) && !request.counts && request.run.fixed.empty();
}

std::vector<std::uint32_t> progressive(const SampleRequest& request, const Domain& domain,
                                       std::span<const Point> points, const Control& control) {
    if (request.region.is_on_globe()) return progressive_order_on_globe(points, control.stop, *control.executor);
    return progressive_order(domain, points, is_uniform(request), control.stop, *control.executor);
}

/// Checks that the ordering was not stopped, unless partial results are accepted.
Result<void> check_order(const SampleRequest& request, Distribution& points, const std::stop_token& stop) {
    points.stopped = points.stopped || stop.stop_requested();
    return check_whole(points.stopped, request.on_deadline);
}

/// Orders the dots of each group along a short path.
std::vector<std::uint32_t> along_paths(const ClassDots& dots, const std::stop_token& stop) {
    if (dots.feature_of.empty()) return short_path(dots.dots.points, stop);
    std::vector<std::uint32_t> order;
    for_features(dots.feature_of, [&](std::uint32_t, std::size_t first, std::size_t count) {
        for (const std::uint32_t i : short_path(std::span(dots.dots.points).subspan(first, count), stop))
            order.push_back(static_cast<std::uint32_t>(first) + i);
    });
    return order;
}

std::vector<std::uint32_t> inverse(std::span<const std::uint32_t> order) {
    std::vector<std::uint32_t> positions(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) positions[order[i]] = i;
    return positions;
}

}  // namespace

Result<void> order_points(const SampleRequest& request, const Domain& whole, ClassDots& dots, const Control& control) {
    switch (order_of(request)) {
        case PointOrder::None:
            return {};
        case PointOrder::Path:
            reorder(dots.dots, along_paths(dots, control.stop));
            return {};
        case PointOrder::Progressive: {
            auto order = progressive(request, whole, dots.dots.points, control);
            const auto ranks = inverse(order);
            if (!dots.feature_of.empty())
                std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return dots.feature_of[i]; });
            reorder(dots.dots, order);
            dots.dots.ranks.clear();
            for (const std::uint32_t i : order) dots.dots.ranks.push_back(ranks[i]);
            return check_order(request, dots.dots, control.stop);
        }
    }
    return {};
}

}  // namespace ccdt::api
