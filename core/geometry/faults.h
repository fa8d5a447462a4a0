#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/ring_input.h"
#include "core/geometry/unit_frame.h"

namespace ccdt {

/// What was wrong with a polygon and has been put right.
struct Repair {
    std::string field;   ///< JSON Pointer below the polygon: /part/ring/vertex, as far as it is known
    std::string detail;  ///< for people: the rings, what is wrong, and where in the caller's coordinates
};

/// What may be wrong with a ring, alone or with another one; the worse, the later.
enum class Fault { Touches, IsCut, Overlaps, LiesOutside, RunsAlong, Crosses, HasNoArea };

/// Collects what is wrong with rings, and puts it into words: of two rings only the worst.
class Faults {
public:
    static constexpr std::size_t kNoCorner = ~std::size_t{0};

    /// @param ring    index of the ring
    /// @param other   the ring it is wrong with; itself, if there is no other
    /// @param corner  of the ring, near the place; kNoCorner if none is
    /// @param place   in the unit frame
    void add(Fault fault, std::size_t ring, std::size_t other, std::size_t corner, Point place);

    bool empty() const { return found_.empty(); }

    /// Whether anything is wrong with a ring.
    bool concerns(std::size_t ring) const { return concerned_.contains(ring); }

    /// In the order of the rings; the first hundred, and one that counts the others. Rings without area have no other
    /// fault.
    std::vector<Repair> describe(std::span<const RingInput> rings, const UnitFrame& frame) const;

private:
    struct Found {
        Fault fault = Fault::Touches;
        std::size_t corner = kNoCorner;
        Point place;
        std::size_t places = 0;
    };
    std::map<std::pair<std::size_t, std::size_t>, Found> found_;  ///< by the ring and the other one
    std::set<std::size_t> concerned_;
};

}  // namespace ccdt
