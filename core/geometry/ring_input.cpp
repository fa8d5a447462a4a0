// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/ring_input.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace ccdt {

namespace {

bool is_finite(Point p) {
    return std::isfinite(p.x) && std::isfinite(p.y);
}

Result<RingInput> read_ring(const Ring& given, std::size_t part, std::size_t number) {
    RingInput ring{part, number, given, std::vector<std::size_t>(given.size())};
    std::iota(ring.source.begin(), ring.source.end(), std::size_t{0});
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (is_finite(given[i])) continue;
        return failure(ErrorCode::Unusable, "vertex " + std::to_string(i) + " of " + ring.name() + " is not finite",
                       ring.pointer(i));
    }
    ring.drop_repeated();
    return ring;
}

}  // namespace

void RingInput::drop_repeated() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (kept > 0 && corners[i] == corners[kept - 1]) continue;
        corners[kept] = corners[i];
        source[kept++] = source[i];
    }
    while (kept > 1 && corners[kept - 1] == corners[0]) --kept;
    corners.resize(kept);
    source.resize(kept);
}

std::string RingInput::name() const {
    const std::string of = part > 0 || ring == 0 ? " of part " + std::to_string(part) : "";
    return ring == 0 ? "the outer ring" + of : "hole " + std::to_string(ring - 1) + of;
}

std::string RingInput::pointer() const {
    return "/" + std::to_string(part) + "/" + std::to_string(ring);
}

std::string RingInput::pointer(std::size_t corner) const {
    return pointer() + "/" + std::to_string(source[corner]);
}

Result<std::vector<RingInput>> read_rings(const std::vector<PolygonPart>& parts) {
    std::vector<RingInput> rings;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        for (std::size_t r = 0; r <= parts[p].holes.size(); ++r) {
            auto ring = read_ring(r == 0 ? parts[p].outer : parts[p].holes[r - 1], p, r);
            if (!ring) return tl::unexpected(ring.error());
            rings.push_back(std::move(*ring));
        }
    }
    if (rings.empty()) return failure(ErrorCode::Unusable, "a domain needs at least one polygon");
    return rings;
}

}  // namespace ccdt
