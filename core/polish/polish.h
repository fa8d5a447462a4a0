#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"
#include "core/polish/transport.h"

namespace ccdt {

/// Distances are over that of neighbours in a hexagonal grid.
struct PolishOptions {
    int rounds = 4;         ///< that push near neighbours apart and even out long waves
    int even_rounds = 3;    ///< then, that only even out
    int near_rounds = 2;    ///< last, that only push the nearest ones: too few to make waves
    double reach = 0.93;    ///< distance below which neighbours are pushed
    double push = 0.4;      ///< share of what is missing by which each of the two moves
    double nearest = 0.72;  ///< reach of the last rounds, which make up what is missing

    int all_rounds() const { return rounds + even_rounds + near_rounds; }
};

/// Keeps sites out of parts without any density.
class Ink {
public:
    /// Both must outlive this.
    Ink(const Domain& domain, const Density& density);

    /// The point itself where there is density, else the nearest point with some, looked for so far; if there is none,
    /// the point itself. O(cells so far).
    Point nearest(Point p, double reach) const;

private:
    std::optional<Point> nearest_within(Point g, int column, int row, int around) const;

    const Density& density_;
    Point to_grid_;
};

/// What triangles of equal capacity leave undone: near neighbours are pushed apart, and what is left of long waves of
/// density error, most of it along the border and where the density is steep, is transported away.
class Polish {
public:
    /// All must outlive this. Long waves are evened out in boxes and on tori only.
    /// @param stop  asked now and then; leaves what is of no use
    Polish(const Domain& domain, const Density& density, std::size_t sites, const std::stop_token& stop = {});

    /// Evens out first sites, which no triangulation binds yet: they may cross gaps in the density.
    /// Nothing happens for a uniform density.
    void even_out(std::span<Point> sites, const std::stop_token& stop);

    /// Moves the sites of a triangulation. All triangles stay counter-clockwise; the Delaunay property is lost.
    /// @param stop   asked several times a round
    /// @param after  called after each round that was not stopped; may be empty
    void refine(Triangulation& mesh, const PolishOptions& options, const std::stop_token& stop,
                const std::function<void()>& after = {});

    /// The steps of refine(), for several inks in turn. begin() comes first, and again after all that changes edges.
    ///
    /// @param pushed  [sites] or empty: how far others push each site
    /// @param moves   [sites]
    void begin(const Triangulation& mesh);
    void push_apart(Triangulation& mesh, double reach, double push, std::span<const Point> pushed,
                    const std::stop_token& stop);
    void even_out(Triangulation& mesh, const std::stop_token& stop);
    void move(Triangulation& mesh, std::span<const Point> moves);

    /// Takes sites where there is no density to the nearest place with some.
    /// @returns  whether there were any
    bool clear_gaps(std::span<Point> sites) const;

private:
    void apply(Triangulation& mesh);
    void take_back(Triangulation& mesh);
    bool is_sound(const Triangulation& mesh, std::uint32_t triangle, double area) const;
    Point inside(Point p) const;
    Point allowed(Point p, double spacing) const;
    double spacing(Point p) const;

    const Domain& domain_;
    const Density& density_;
    std::optional<Transport> transport_;
    Ink ink_;
    std::vector<std::uint32_t> edges_;  ///< half-edges between sites
    std::vector<Point> moves_, before_;
    std::vector<double> spacings_;
    std::vector<double> areas_, moved_areas_;  ///< doubled [triangles], before a move and after it
};

}  // namespace ccdt
