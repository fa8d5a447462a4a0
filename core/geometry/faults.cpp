// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/faults.h"

#include <charconv>
#include <utility>

namespace ccdt {

namespace {

/// Formats a number with ten digits, which hides rounding errors of the unit frame.
std::string written(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 10).ptr};
}

std::string words_of(Fault fault, const RingInput& ring, const RingInput& other) {
    const std::string with = &ring == &other ? "itself" : other.name();
    switch (fault) {
        case Fault::Touches:
            return "touches " + with;
        case Fault::IsCut:
            return "is cut into pieces where holes touch";
        case Fault::Overlaps:
            return "overlaps " + with;
        case Fault::LiesOutside:
            return "lies outside its polygon";
        case Fault::RunsAlong:
            return "runs along " + with;
        case Fault::Crosses:
            return "crosses " + with;
        case Fault::HasNoArea:
            return "has no area";
    }
    return {};
}

}  // namespace

void Faults::add(Fault fault, std::size_t ring, std::size_t other, std::size_t corner, Point position) {
    if (other > ring) {
        std::swap(ring, other);
        corner = kNoCorner;
    }
    concerned_.insert({ring, other});
    Found& found = found_[{ring, other}];
    if (fault < found.fault) return;
    if (found.positions == 0 || fault > found.fault) found = {fault, corner, position, 0};
    ++found.positions;
}

std::vector<Repair> Faults::describe(std::span<const RingInput> rings, const UnitFrame& frame) const {
    constexpr std::size_t kMax = 100;
    const auto is_flat = [&](std::size_t ring) {
        const auto own = found_.find({ring, ring});
        return own != found_.end() && own->second.fault == Fault::HasNoArea;
    };
    std::vector<Repair> repairs;
    std::size_t others = 0;
    for (const auto& [pair, found] : found_) {
        if (found.fault != Fault::HasNoArea && (is_flat(pair.first) || is_flat(pair.second))) continue;
        if (repairs.size() == kMax) {
            ++others;
            continue;
        }
        const RingInput& ring = rings[pair.first];
        const Point position = frame.to_user(found.position);
        std::string detail = ring.name() + ' ' + words_of(found.fault, ring, rings[pair.second]) + " at (" +
                             written(position.x) + ", " + written(position.y) + ')';
        const bool is_at_points = found.fault == Fault::Touches || found.fault >= Fault::RunsAlong;
        if (found.positions == 2 && is_at_points) detail += " and in another place";
        if (found.positions > 2 && is_at_points)
            detail += " and in " + std::to_string(found.positions - 1) + " other places";
        repairs.push_back({found.corner == kNoCorner ? ring.pointer() : ring.pointer(found.corner), std::move(detail)});
    }
    if (others > 0) repairs.push_back({{}, std::to_string(others) + " more such faults"});
    return repairs;
}

}  // namespace ccdt
