// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface_repair.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/elementary.h"
#include "core/ccdt/surface/party_walls.h"
#include "core/ccdt/surface/shell_nesting.h"
#include "core/geometry/morton.h"
#include "core/mesh/triangle_links.h"

namespace ccdt {

namespace {

using Face = ConnectedTriangles::Face;
using Corners = std::array<std::uint32_t, 3>;
using Links = TriangleLinks;

constexpr std::uint32_t kNone = ConnectedTriangles::kNone;
constexpr std::size_t kStopStride = std::size_t{1} << 16;

/// Counts the occurrences of one repair.
struct Count {
    std::size_t number = 0;
    std::uint32_t first = kNone;  ///< first triangle concerned

    void add(std::uint32_t triangle) {
        ++number;
        first = std::min(first, triangle);
    }
};

/// Returns the two sides at the largest angle of a triangle, in cyclic order.
std::array<Point3, 2> shorter_sides(const std::array<Point3, 3>& triangle) {
    const auto& [a, b, c] = triangle;
    const std::array<Point3, 3> sides{b - a, c - b, a - c};
    const auto longest = static_cast<std::uint32_t>(
        std::max_element(sides.begin(), sides.end(), [](Point3 u, Point3 v) { return dot(u, u) < dot(v, v); }) -
        sides.begin());
    return {sides[Links::next(longest)], sides[Links::previous(longest)]};
}

class Connector {
public:
    Connector(std::span<const Point3> positions, std::span<const Corners> triangles, const std::stop_token& stop)
        : positions_(positions), triangles_(triangles), stop_(stop) {}

    Result<ConnectedTriangles> run();

private:
    /// A half-edge, listed at the end with the lower number.
    struct Side {
        std::uint32_t high;      ///< the other end, with the higher number
        std::uint32_t opposite;  ///< third vertex of the triangle
        std::uint32_t edge;

        friend bool operator<(const Side& a, const Side& b) {
            return std::tie(a.high, a.opposite, a.edge) < std::tie(b.high, b.opposite, b.edge);
        }
    };

    /// A half-edge, with the angle of its face around the edge.
    struct Angle {
        double angle;
        std::uint32_t edge;

        friend bool operator<(const Angle& a, const Angle& b) {
            return std::tie(a.angle, a.edge) < std::tie(b.angle, b.edge);
        }
    };

    /// Faces that are connected by edges.
    struct Component {
        std::uint32_t begin, end;  ///< range of component_faces_
        bool is_closed = false;
        bool is_turned = false;  ///< whether its faces must be turned over, compared with Face::turned
        double volume = 0;       ///< six times the enclosed volume after turning, before turn_closed()
    };

    bool stopping() const { return stop_.stop_requested(); }
    Face& face_of(std::uint32_t edge) { return result_.faces[edge / 4]; }
    std::uint32_t tail(std::uint32_t edge) const { return result_.faces[edge / 4].corners[edge % 4]; }
    std::uint32_t& twin(std::uint32_t edge) { return face_of(edge).twins[edge % 4]; }
    bool is_removed(std::uint32_t face) const { return removed_[face] != 0; }
    void remove(std::uint32_t face, Count& count);

    void number_positions();
    void take_triangles();
    void pair_edges();
    template <class Function>
    void for_all_edges(Function&& function);
    void remove_repeated(std::span<const Side> sides);
    void remove_walls();
    void remove_flat(std::span<const Side> sides);
    void pair(std::uint32_t low, std::span<const Side> sides);
    bool pair_by_angle(std::uint32_t low, std::uint32_t high);
    void join(std::uint32_t edge, std::uint32_t other);
    void cut(std::uint32_t edge, Count& count);

    void orient();
    Component collect_component(std::uint32_t first);
    std::span<const std::uint32_t> faces_of(const Component& component) const;
    double volume(const Component& component) const;
    void turn_closed(std::vector<Component>& components) const;
    void finish_component(const Component& component);
    void remove_flat_borders();
    std::uint32_t longest_side(const Face& face) const;
    void apply_turns();
    void sort_faces();
    void split_vertices();
    void number_fan(std::uint32_t face, std::uint32_t corner, std::uint32_t number,
                    std::vector<Corners>& numbers) const;
    void note();

    std::span<const Point3> positions_;
    std::span<const Corners> triangles_;
    const std::stop_token& stop_;
    ConnectedTriangles result_;

    std::vector<std::uint32_t> vertex_of_;   ///< [positions] first position that is equal
    std::vector<std::uint8_t> removed_;      ///< [faces]
    std::vector<std::uint8_t> visited_;      ///< [faces]
    std::vector<std::uint8_t> on_cut_;       ///< [positions] whether the vertex is an end of a cut edge
    std::vector<std::uint32_t> first_side_;  ///< [positions + 2] start of each vertex's sides
    std::vector<Side> sides_;
    std::vector<Angle> group_;  ///< sides of the current edge
    std::vector<std::uint32_t> component_faces_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> opposite_;  ///< equal faces with opposite orientations
    Count without_area_, flat_, repeated_, walls_, turned_, touching_edges_, shared_edges_, one_sided_edges_,
        shared_vertices_;
};

void Connector::remove(std::uint32_t face, Count& count) {
    if (is_removed(face)) return;
    removed_[face] = 1;
    count.add(result_.faces[face].triangle);
}

/// Finds equal positions by sorting them along the curve, and by their coordinates where it has the same value.
void Connector::number_positions() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(positions_.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = {morton_position(positions_[i]), i};
    const auto key = [this](const auto& entry) {
        const Point3 p = positions_[entry.second];
        return std::tuple(p.x, p.y, p.z);
    };
    std::ranges::sort(order, [&key](const auto& a, const auto& b) {
        if (a.first != b.first) return a.first < b.first;
        return std::tuple(key(a), a.second) < std::tuple(key(b), b.second);
    });
    vertex_of_.resize(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool repeats = i > 0 && key(order[i]) == key(order[i - 1]);
        vertex_of_[order[i].second] = repeats ? vertex_of_[order[i - 1].second] : order[i].second;
    }
}

void Connector::take_triangles() {
    result_.faces.reserve(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto triangle = static_cast<std::uint32_t>(t);
        const auto [a, b, c] = triangles_[t];
        const Corners corners{vertex_of_[a], vertex_of_[b], vertex_of_[c]};
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
            without_area_.add(triangle);
            continue;
        }
        result_.faces.push_back({.corners = corners,
                                 .triangle = triangle,
                                 .flat = ConnectedTriangles::is_flat({positions_[a], positions_[b], positions_[c]})});
    }
    removed_.resize(result_.faces.size());
    on_cut_.resize(positions_.size());
}

/// Lists the sides of all faces by their lower vertices, and pairs the sides of each edge.
void Connector::pair_edges() {
    first_side_.assign(positions_.size() + 2, 0);
    const auto for_sides = [this](auto&& function) {
        for (std::size_t f = 0; f < result_.faces.size(); ++f) {
            const Corners& corners = result_.faces[f].corners;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax(corners[k], corners[Links::next(k)]);
                function(low, Side{high, corners[Links::previous(k)], static_cast<std::uint32_t>(4 * f + k)});
            }
        }
    };
    for_sides([this](std::uint32_t low, const Side&) { ++first_side_[low + 2]; });
    for (std::size_t v = 2; v < first_side_.size(); ++v) first_side_[v] += first_side_[v - 1];
    sides_.resize(first_side_.back());
    for_sides([this](std::uint32_t low, const Side& side) { sides_[first_side_[low + 1]++] = side; });

    for (std::size_t v = 0; v < positions_.size(); ++v)
        std::sort(sides_.begin() + first_side_[v], sides_.begin() + first_side_[v + 1]);
    for_all_edges([this](std::uint32_t, std::span<const Side> sides) { remove_repeated(sides); });
    remove_walls();
    for_all_edges([this](std::uint32_t, std::span<const Side> sides) { remove_flat(sides); });
    for_all_edges([this](std::uint32_t low, std::span<const Side> sides) { pair(low, sides); });
    sides_ = std::vector<Side>();  // frees the memory
    first_side_ = std::vector<std::uint32_t>();
}

/// Calls a function with the lower vertex and the sides of each edge.
template <class Function>
void Connector::for_all_edges(Function&& function) {
    for (std::uint32_t low = 0; low < positions_.size(); ++low) {
        if (low % kStopStride == 0 && stopping()) return;
        const std::size_t end = first_side_[low + 1];
        for (std::size_t begin = first_side_[low]; begin < end;) {
            std::size_t last = begin + 1;
            while (last < end && sides_[last].high == sides_[begin].high) ++last;
            function(low, std::span<const Side>(&sides_[begin], last - begin));
            begin = last;
        }
    }
}

/// Removes all but the first of equal triangles. Two triangles with opposite orientations are left to remove_walls().
void Connector::remove_repeated(std::span<const Side> sides) {
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && sides[end].opposite == sides[begin].opposite) ++end;
        const std::uint32_t first = sides[begin].edge, second = sides[end - 1].edge;
        if (end - begin == 2 && tail(first) != tail(second)) {
            if (first % 4 == 0) opposite_.emplace_back(first / 4, second / 4);
            continue;
        }
        for (std::size_t i = begin + 1; i < end; ++i) remove(sides[i].edge / 4, repeated_);
    }
}

/// Removes walls between parts. Of other triangles with the same corners and opposite orientations, the first remains.
void Connector::remove_walls() {
    std::vector<CrowdedSide> crowded;
    std::uint32_t edges = 0;
    for_all_edges([&](std::uint32_t, std::span<const Side> sides) {
        group_.clear();
        for (const Side& side : sides) {
            if (!is_removed(side.edge / 4)) group_.push_back({0, side.edge});
        }
        if (group_.size() == 2) join(group_[0].edge, group_[1].edge);
        if (group_.size() <= 2) return;
        for (const Angle& side : group_) crowded.push_back({edges, side.edge});
        ++edges;
    });
    if (stopping()) return;
    if (!crowded.empty()) {
        std::vector<WallFace> faces;
        for (const Face& face : result_.faces) faces.push_back({face.corners, face.twins});
        for (const std::uint32_t face : party_walls(positions_, faces, crowded)) remove(face, walls_);
    }
    for (const auto& [first, second] : opposite_) {
        if (!is_removed(first)) remove(second, repeated_);
    }
    for (Face& face : result_.faces) face.twins = {kNone, kNone, kNone};
}

void Connector::remove_flat(std::span<const Side> sides) {
    const auto remains = [this](const Side& side) { return !is_removed(side.edge / 4); };
    if (sides.size() <= 2 || std::count_if(sides.begin(), sides.end(), remains) <= 2) return;
    for (const Side& side : sides) {
        if (face_of(side.edge).flat) remove(side.edge / 4, flat_);
    }
}

void Connector::pair(std::uint32_t low, std::span<const Side> sides) {
    group_.clear();
    for (const Side& side : sides) {
        if (!is_removed(side.edge / 4)) group_.push_back({0, side.edge});
    }
    if (group_.size() == 2) join(group_[0].edge, group_[1].edge);
    if (group_.size() <= 2) return;
    const std::uint32_t high = sides.front().high;
    on_cut_[low] = on_cut_[high] = 1;
    // Faces are in the order of the triangles.
    const auto by_edge = [](const Angle& a, const Angle& b) { return a.edge < b.edge; };
    const std::uint32_t first = std::min_element(group_.begin(), group_.end(), by_edge)->edge;
    Count& count = pair_by_angle(low, high) ? touching_edges_ : shared_edges_;
    count.add(face_of(first).triangle);
}

/// Pairs the sides in group_ such that each pair bounds a wedge of the inside. Returns false if the orientations of the
/// faces contradict each other.
bool Connector::pair_by_angle(std::uint32_t low, std::uint32_t high) {
    const Point3 axis = positions_[high] - positions_[low];
    const auto opposite = [this](std::uint32_t edge) {
        return positions_[face_of(edge).corners[Links::previous(edge % 4)]];
    };
    const Point3 across = cross(axis, opposite(group_.front().edge) - positions_[low]);
    const Point3 outwards = cross(across, 1 / length(axis) * axis);
    for (Angle& side : group_) {
        const Point3 p = opposite(side.edge) - positions_[low];
        side.angle = elementary::atan2(dot(p, across), dot(p, outwards));
    }
    std::sort(group_.begin(), group_.end());
    // The inside is at larger angles if the edge runs downwards, and at smaller angles if it runs upwards.
    const auto runs_up = [&](const Angle& side) { return tail(side.edge) == low; };
    std::rotate(group_.begin(), std::find_if_not(group_.begin(), group_.end(), runs_up), group_.end());
    for (std::size_t i = 0; i < group_.size(); ++i) {
        if (runs_up(group_[i]) != (i % 2 == 1)) return false;
    }
    if (group_.size() % 2 == 1) return false;
    for (std::size_t i = 0; i < group_.size(); i += 2) join(group_[i].edge, group_[i + 1].edge);
    return true;
}

void Connector::join(std::uint32_t edge, std::uint32_t other) {
    twin(edge) = other;
    twin(other) = edge;
}

/// Separates the two faces at an edge.
void Connector::cut(std::uint32_t edge, Count& count) {
    const std::uint32_t other = std::exchange(twin(edge), kNone);
    twin(other) = kNone;
    count.add(face_of(edge).triangle);
}

void Connector::orient() {
    visited_.assign(result_.faces.size(), 0);
    std::vector<Component> components;
    for (std::size_t f = 0; f < result_.faces.size(); ++f) {
        if (f % kStopStride == 0 && stopping()) return;
        const auto face = static_cast<std::uint32_t>(f);
        if (!visited_[f] && !is_removed(face)) components.push_back(collect_component(face));
    }
    turn_closed(components);
    for (const Component& component : components) finish_component(component);
}

/// Turns all faces that are connected to a face such that they have its orientation. Then chooses the orientation that
/// most of the faces were given.
Connector::Component Connector::collect_component(std::uint32_t first) {
    Component component{static_cast<std::uint32_t>(component_faces_.size()), 0};
    component_faces_.push_back(first);
    visited_[first] = 1;
    for (std::size_t i = component.begin; i < component_faces_.size(); ++i) {
        const std::uint32_t f = component_faces_[i];
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t edge = 4 * f + k;
            const std::uint32_t other = twin(edge);
            if (other == kNone) continue;
            Face& neighbour = face_of(other);
            const bool turned = result_.faces[f].turned != (tail(edge) == tail(other));
            if (!visited_[other / 4]) {
                visited_[other / 4] = 1;
                neighbour.turned = turned;
                component_faces_.push_back(other / 4);
            } else if (neighbour.turned != turned) {
                on_cut_[tail(edge)] = on_cut_[result_.faces[f].corners[Links::next(k)]] = 1;
                cut(edge, one_sided_edges_);
            }
        }
    }
    component.end = static_cast<std::uint32_t>(component_faces_.size());
    const auto faces = faces_of(component);
    const auto turned = std::ranges::count_if(faces, [this](std::uint32_t f) { return result_.faces[f].turned; });
    component.is_turned = 2 * static_cast<std::size_t>(turned) > faces.size();
    component.is_closed = std::ranges::all_of(faces, [this](std::uint32_t f) {
        return std::ranges::find(result_.faces[f].twins, kNone) == result_.faces[f].twins.end();
    });
    if (component.is_closed) component.volume = volume(component);
    return component;
}

std::span<const std::uint32_t> Connector::faces_of(const Component& component) const {
    return std::span(component_faces_).subspan(component.begin, component.end - component.begin);
}

/// Turns closed components that are inside out. A component inside another one may be a cavity, so it usually keeps its
/// orientation. But if the outermost component around it is turned, the components inside are turned such that bodies
/// and cavities alternate.
void Connector::turn_closed(std::vector<Component>& components) const {
    std::vector<std::uint32_t> closed;
    for (std::uint32_t i = 0; i < components.size(); ++i) {
        if (components[i].is_closed) closed.push_back(i);
    }
    const auto is_inside_out = [&](std::uint32_t i) { return components[i].volume < 0; };
    if (std::ranges::none_of(closed, is_inside_out)) return;
    std::vector<std::vector<std::uint32_t>> around;
    if (closed.size() > 1) {
        std::vector<ShellFace> faces;
        std::vector<Point3> points;
        for (const std::uint32_t i : closed) {
            for (const std::uint32_t f : faces_of(components[i]))
                faces.push_back({result_.faces[f].corners, static_cast<std::uint32_t>(points.size())});
            const auto& [a, b, c] = faces.back().corners;
            points.push_back(1.0 / 3 * (positions_[a] + positions_[b] + positions_[c]));
        }
        around = shells_around(positions_, faces, points);
    }
    around.resize(closed.size());
    for (std::size_t i = 0; i < closed.size(); ++i) {
        const auto outermost =
            std::ranges::find_if(around[i], [&](std::uint32_t shell) { return around[shell].empty(); });
        const bool is_free = around[i].empty() || (outermost != around[i].end() && is_inside_out(closed[*outermost]));
        const bool is_cavity = around[i].size() % 2 == 1;
        if (is_free && is_inside_out(closed[i]) != is_cavity) components[closed[i]].is_turned ^= true;
    }
}

/// Applies the orientation of a component, or removes it if it has no area.
void Connector::finish_component(const Component& component) {
    const auto faces = faces_of(component);
    const bool is_flat = std::ranges::all_of(faces, [this](std::uint32_t f) { return result_.faces[f].flat; });
    for (const std::uint32_t f : faces) {
        Face& face = result_.faces[f];
        face.turned = face.turned != component.is_turned;
        if (is_flat)
            remove(f, flat_);
        else if (face.turned)
            turned_.add(face.triangle);
    }
}

/// Returns six times the volume that a component encloses.
double Connector::volume(const Component& component) const {
    const auto faces = faces_of(component);
    const Point3 origin = positions_[result_.faces[faces.front()].corners[0]];
    double sum = 0;
    for (const std::uint32_t f : faces) {
        const auto& [a, b, c] = result_.faces[f].corners;
        const double part = dot(positions_[a] - origin, cross(positions_[b] - origin, positions_[c] - origin));
        sum += result_.faces[f].turned != component.is_turned ? -part : part;
    }
    return sum;
}

/// Removes flat faces whose longest edge is on a border, because they connect nothing.
void Connector::remove_flat_borders() {
    std::vector<std::uint32_t> remaining;
    for (std::size_t f = 0; f < result_.faces.size(); ++f) {
        remaining.assign(1, static_cast<std::uint32_t>(f));
        while (!remaining.empty()) {
            const std::uint32_t at = remaining.back();
            remaining.pop_back();
            Face& face = result_.faces[at];
            if (!face.flat || is_removed(at) || face.twins[longest_side(face)] != kNone) continue;
            remove(at, flat_);
            for (std::uint32_t& other : face.twins) {
                if (other == kNone) continue;
                remaining.push_back(other / 4);
                twin(std::exchange(other, kNone)) = kNone;
            }
        }
    }
}

std::uint32_t Connector::longest_side(const Face& face) const {
    std::uint32_t longest = 0;
    double most = 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const double side = length(positions_[face.corners[Links::next(k)]] - positions_[face.corners[k]]);
        if (side > most) longest = k;
        most = std::max(most, side);
    }
    return longest;
}

void Connector::apply_turns() {
    for (Face& face : result_.faces) {
        for (std::uint32_t& other : face.twins) {
            if (other != kNone && face_of(other).turned && other % 4 != 1) other ^= 2;
        }
    }
    for (Face& face : result_.faces) {
        if (!face.turned) continue;
        std::swap(face.corners[1], face.corners[2]);
        std::swap(face.twins[0], face.twins[2]);
    }
}

/// Drops removed faces, and sorts the others along the curve.
void Connector::sort_faces() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
    for (std::uint32_t f = 0; f < removed_.size(); ++f) {
        const auto& [a, b, c] = result_.faces[f].corners;
        if (!removed_[f])
            order.emplace_back(morton_position(1.0 / 3 * (positions_[a] + positions_[b] + positions_[c])), f);
    }
    std::ranges::sort(order);
    std::vector<std::uint32_t> numbers(removed_.size());
    const std::vector<Face> unsorted = std::exchange(result_.faces, {});
    result_.faces.reserve(order.size());
    for (const auto& [position, f] : order) {
        numbers[f] = static_cast<std::uint32_t>(result_.faces.size());
        result_.faces.push_back(unsorted[f]);
    }
    for (Face& face : result_.faces) {
        for (std::uint32_t& other : face.twins) {
            if (other != kNone) other = 4 * numbers[other / 4] + other % 4;
        }
    }
}

/// Numbers vertices such that each fan of faces around a position has its own vertex.
void Connector::split_vertices() {
    std::vector<Corners> numbers(result_.faces.size(), Corners{kNone, kNone, kNone});
    std::vector<std::uint8_t> seen(positions_.size());
    for (std::size_t f = 0; f < result_.faces.size(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (numbers[f][k] != kNone) continue;
            const std::uint32_t position = result_.faces[f].corners[k];
            if (std::exchange(seen[position], 1) && !on_cut_[position]) shared_vertices_.add(result_.faces[f].triangle);
            number_fan(static_cast<std::uint32_t>(f), k, static_cast<std::uint32_t>(result_.vertices.size()), numbers);
            result_.vertices.push_back(positions_[position]);
        }
    }
    for (std::size_t f = 0; f < result_.faces.size(); ++f) result_.faces[f].corners = numbers[f];
}

void Connector::number_fan(std::uint32_t face, std::uint32_t corner, std::uint32_t number,
                           std::vector<Corners>& numbers) const {
    const std::uint32_t start = 4 * face + corner;
    std::uint32_t at = start;
    do {
        numbers[at / 4][at % 4] = number;
        at = result_.faces[at / 4].twins[Links::previous(at % 4)];
    } while (at != kNone && at != start);
    if (at == start) return;
    at = result_.faces[face].twins[corner];
    while (at != kNone) {
        const std::uint32_t side = Links::next(at % 4);
        numbers[at / 4][side] = number;
        at = result_.faces[at / 4].twins[side];
    }
}

void Connector::note() {
    const auto add = [this](const Count& count, const char* one, const char* many) {
        if (count.number == 0) return;
        result_.repairs.push_back(
            {count.number == 1 ? one : std::to_string(count.number) + many, count.number, count.first});
    };
    add(without_area_, "1 triangle with coincident corners was removed",
        " triangles with coincident corners were removed");
    add(flat_, "1 triangle without area was removed", " triangles without area were removed");
    add(repeated_, "1 repeated triangle was removed", " repeated triangles were removed");
    add(walls_, "1 triangle of a wall between two parts was removed",
        " triangles of walls between two parts were removed");
    add(turned_, "1 triangle was turned over", " triangles were turned over");
    add(touching_edges_, "the surface was cut along 1 edge where it only touches itself",
        " edges where the surface only touches itself were cut");
    add(shared_edges_, "the surface was cut along 1 edge that more than two triangles share",
        " edges that more than two triangles share were cut");
    add(one_sided_edges_, "the surface was cut along 1 edge, because it has only one side",
        " edges were cut, because the surface has only one side");
    add(shared_vertices_, "the surface was cut at 1 vertex where it only touches itself",
        " vertices where the surface only touches itself were cut");
}

Result<ConnectedTriangles> Connector::run() {
    constexpr std::array kSteps{&Connector::number_positions, &Connector::take_triangles,      &Connector::pair_edges,
                                &Connector::orient,           &Connector::remove_flat_borders, &Connector::apply_turns,
                                &Connector::sort_faces,       &Connector::split_vertices};
    for (const auto step : kSteps) {
        (this->*step)();
        if (stopping()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    }
    note();
    return std::move(result_);
}

}  // namespace

Point3 ConnectedTriangles::doubled_area(const std::array<Point3, 3>& triangle) {
    const auto [u, v] = shorter_sides(triangle);
    return cross(u, v);
}

bool ConnectedTriangles::is_flat(const std::array<Point3, 3>& triangle) {
    constexpr double kMinSine = 1e-10;  // rounding turns the normal by 1e-6
    const auto [u, v] = shorter_sides(triangle);
    return !(length(cross(u, v)) > kMinSine * length(u) * length(v));
}

Result<ConnectedTriangles> connect_triangles(std::span<const Point3> positions,
                                             std::span<const std::array<std::uint32_t, 3>> triangles,
                                             const std::stop_token& stop) {
    return Connector(positions, triangles, stop).run();
}

}  // namespace ccdt
