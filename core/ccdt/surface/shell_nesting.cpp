// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/shell_nesting.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ccdt {

namespace {

/// Points in a grid over y and z.
class PointGrid {
public:
    explicit PointGrid(std::span<const Point3> points)
        : size_(
              std::clamp<std::size_t>(static_cast<std::size_t>(std::sqrt(static_cast<double>(points.size()))), 1, 512)),
          cells_(size_ * size_) {
        for (std::uint32_t i = 0; i < points.size(); ++i)
            cells_[cell(points[i].z) * size_ + cell(points[i].y)].push_back(i);
    }

    /// Calls a function with the points of the cells that a box touches.
    template <class Function>
    void for_points(const Box3& box, Function&& function) const {
        for (std::size_t row = cell(box.min.z); row <= cell(box.max.z); ++row) {
            for (std::size_t column = cell(box.min.y); column <= cell(box.max.y); ++column) {
                for (const std::uint32_t i : cells_[row * size_ + column]) function(i);
            }
        }
    }

private:
    std::size_t cell(double ordinate) const {
        return std::min(static_cast<std::size_t>(ordinate * static_cast<double>(size_)), size_ - 1);
    }

    std::size_t size_;
    std::vector<std::vector<std::uint32_t>> cells_;
};

/// Whether the ray from p along x crosses a triangle. An edge gives the same result in both of its triangles, so the
/// ray crosses a closed surface an even number of times from outside.
bool crosses(Point3 p, std::span<const Point3> positions, const std::array<std::uint32_t, 3>& corners) {
    bool is_inside = false;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(corners[k], corners[(k + 1) % 3]);
        const Point3 a = positions[low], b = positions[high];
        if ((a.z > p.z) != (b.z > p.z) && a.y + (p.z - a.z) / (b.z - a.z) * (b.y - a.y) > p.y) is_inside = !is_inside;
    }
    if (!is_inside) return false;
    const Point3 a = positions[corners[0]], normal = cross(positions[corners[1]] - a, positions[corners[2]] - a);
    return normal.x != 0 && a.x - (normal.y * (p.y - a.y) + normal.z * (p.z - a.z)) / normal.x > p.x;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> shells_around(std::span<const Point3> positions,
                                                      std::span<const ShellFace> faces,
                                                      std::span<const Point3> points) {
    const PointGrid grid(points);
    std::vector<std::vector<std::uint32_t>> around(points.size());
    std::size_t tests = 50 * faces.size();
    for (const auto& [corners, shell] : faces) {
        const Box3 box = bounds_of(std::array{positions[corners[0]], positions[corners[1]], positions[corners[2]]});
        grid.for_points(box, [&, shell = shell, &corners = corners](std::uint32_t i) {
            tests -= tests > 0 ? 1 : 0;
            if (tests > 0 && i != shell && crosses(points[i], positions, corners)) around[i].push_back(shell);
        });
        if (tests == 0) return {};
    }
    // A shell whose number of crossings is odd is around the point.
    for (auto& shells : around) {
        std::ranges::sort(shells);
        std::vector<std::uint32_t> odd;
        for (const std::uint32_t shell : shells) {
            if (!odd.empty() && odd.back() == shell)
                odd.pop_back();
            else
                odd.push_back(shell);
        }
        shells = std::move(odd);
    }
    return around;
}

}  // namespace ccdt
