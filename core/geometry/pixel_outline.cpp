// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/pixel_outline.h"

#include <array>
#include <cstdint>
#include <utility>

namespace ccdt {
namespace {

/// Directions of edges, counter-clockwise, with y upwards.
enum Direction : std::uint8_t { Right, Up, Left, Down };

constexpr std::array<int, 4> kStepX{1, 0, -1, 0}, kStepY{0, 1, 0, -1};

Direction turned(Direction direction, int quarters) {
    return static_cast<Direction>((direction + quarters + 4) % 4);
}

/// Follows edges with a marked pixel on their left and an unmarked one on their right.
class Tracer {
public:
    Tracer(const PixelSet& pixels, const Box& box, std::size_t most)
        : pixels_(pixels), box_(box), remaining_(most), seen_(pixels.marked.size(), false) {}

    /// @returns  false if there are too many corners
    bool execute() {
        for (int y = 0; y < pixels_.height; ++y) {
            for (int x = 0; x < pixels_.width; ++x) {
                // Each chain has an edge to the right, along the lower side of a pixel.
                if (is_edge(x, y, Right) && !seen_[index(x, y)] && !follow(x, y)) return false;
            }
        }
        return true;
    }

    Area take() { return std::move(area_); }

private:
    std::size_t index(int x, int y) const {
        const int row = pixels_.height - 1 - y;
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(pixels_.width) + static_cast<std::size_t>(x);
    }

    bool is_marked(int x, int y) const {
        return x >= 0 && y >= 0 && x < pixels_.width && y < pixels_.height && pixels_.marked[index(x, y)];
    }

    /// Whether an edge of the border begins at a pixel corner; (x, y) is the lower left corner of pixel (x, y).
    bool is_edge(int x, int y, Direction direction) const {
        switch (direction) {
            case Right:
                return is_marked(x, y) && !is_marked(x, y - 1);
            case Up:
                return is_marked(x - 1, y) && !is_marked(x, y);
            case Left:
                return is_marked(x - 1, y - 1) && !is_marked(x - 1, y);
            default:
                return is_marked(x, y - 1) && !is_marked(x - 1, y - 1);
        }
    }

    /// Follows the chain that begins with an edge to the right at the corner (x, y).
    bool follow(int x, int y) {
        Ring& ring = area_.emplace_back();
        Direction direction = Right;
        const int first_x = x, first_y = y;
        do {
            if (direction == Right) seen_[index(x, y)] = true;
            x += kStepX[direction];
            y += kStepY[direction];
            // Tries left first, to stay with one pixel where two touch at a corner.
            Direction next = turned(direction, 1);
            while (!is_edge(x, y, next)) next = turned(next, -1);
            if (next == direction) continue;
            if (remaining_-- == 0) return false;
            ring.push_back(position(x, y));
            direction = next;
        } while (x != first_x || y != first_y || direction != Right);
        return true;
    }

    Point position(int x, int y) const {
        return {between(box_.min.x, box_.max.x, x, pixels_.width), between(box_.min.y, box_.max.y, y, pixels_.height)};
    }

    static double between(double low, double high, int step, int steps) {
        if (step == steps) return high;
        return low + (high - low) * (static_cast<double>(step) / steps);
    }

    const PixelSet& pixels_;
    const Box& box_;
    std::size_t remaining_;
    std::vector<bool> seen_;  ///< [pixels] whether the lower side is part of a chain already traced
    Area area_;
};

}  // namespace

std::optional<Area> outline_of(const PixelSet& pixels, const Box& box, std::size_t most) {
    Tracer tracer(pixels, box, most);
    if (!tracer.execute()) return std::nullopt;
    return tracer.take();
}

}  // namespace ccdt
