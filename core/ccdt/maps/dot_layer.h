// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/base/result.h"
#include "core/ccdt/maps/dot_ground.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/plane/domain_mesh.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/polish/fixed_sites.h"
#include "core/ccdt/polish/mesh_transport.h"
#include "core/ccdt/polish/settings.h"
#include "core/ccdt/relax/border.h"
#include "core/ccdt/relax/relaxation.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/move_guard.h"

namespace ccdt {

/// The dots of one class of a map and their triangulation, processed step by step: start(); iterate() while
/// has_next_iteration(); then, if there is a polish, its steps. restore() must follow large moves. After the start,
/// collect() returns the current state.
class DotLayer {
public:
    /// @param ground   must outlive this
    /// @param land     union of all features that have dots of the class
    /// @param control  the control's executor must outlive this
    DotLayer(DotGround& ground, Domain land, const Options& options, const Control& control);
    DotLayer(const DotLayer&) = delete;  // relaxations refer to this object
    DotLayer& operator=(const DotLayer&) = delete;

    /// Draws and triangulates the initial dots. Errors: Unusable for a feature that is too thin; Stopped.
    Result<void> start();

    bool has_next_iteration() const;
    /// Runs the polish steps before an iteration: a push and an even round. Does nothing before early iterations; see
    /// PolishSettings::early.
    void polish_between(const PolishSettings& settings);
    /// Runs one iteration. Returns false after a stop.
    bool iterate();

    std::size_t size() const { return dots_.size(); }
    std::uint32_t feature_of(std::size_t dot) const { return dots_[dot].feature; }
    Point position(std::size_t dot) const { return land_.to_user(mesh().point(static_cast<std::uint32_t>(dot))); }

    /// Pushes apart neighbours that are too close, and adds the given moves.
    /// @param reach   relative to the distance that two neighbours should have
    /// @param push    mean move of the two neighbours, as a share of the missing distance
    /// @param pushed  [dots] moves caused by other classes; may be empty
    void push_apart(double reach, double push, std::span<const Point> pushed);

    /// Removes long waves of density error. Does nothing if the density is not smooth or there are fixed points.
    void even_out();

    /// Restores the Delaunay property, and runs passes of relaxation. Used between rounds of the polish.
    void equalise(int passes);

    /// Returns the least distance of two neighbours, relative to the distance that they should have.
    double least_distance() const;

    /// Restores the Delaunay property.
    void restore();

    /// Measures the capacity variation after the polish.
    void finish();

    ClassDots collect();

    int iterations() const { return result_.iterations; }
    double variation() const { return result_.variation(); }

private:
    bool stopping() const { return stop_.stop_requested(); }
    const Triangulation& mesh() const { return placed_->mesh; }
    Triangulation& mesh() { return placed_->mesh; }
    double scale() const;
    Relaxation& relaxation();
    void relax(int passes);
    double radius(double density) const;
    std::vector<double> length_in_dots(Point a, Point b) const;
    Result<void> choose_fixed(const Border& border);
    Result<void> insert_all();
    Result<void> insert_step(std::span<const std::uint32_t> dots);
    bool keeps_position(std::uint32_t dot) const;
    Result<void> insert_anywhere(std::uint32_t dot);
    void find_radii();
    void find_targets();
    double target_of(std::uint32_t triangle) const;
    double measure();
    void soften_borders();
    MeshTransport make_transport() const;
    Point fenced(std::uint32_t dot, Point to) const;
    void apply();
    Point push_off_neighbours(std::uint32_t dot, double reach, double push) const;
    Point push_off_others(std::uint32_t dot, double reach, double push) const;

    DotGround& ground_;
    Domain land_;
    Options options_;
    std::stop_token stop_;
    Executor& executor_;
    std::optional<DomainMesh> placed_;
    std::vector<FeatureDot> dots_;       ///< in the order of their sites, with their initial positions
    FixedSites fixed_;                   ///< fixed points; their vertices follow the dots' vertices
    std::optional<CellList> others_;     ///< fixed points without a vertex
    std::vector<double> radii_;          ///< [sites] half of the wanted distance between neighbours, in the unit frame
    std::vector<double> targets_;        ///< [triangles] wanted doubled area
    std::vector<double> capacities_;     ///< [triangles] capacity in dots: half of area / wanted area
    std::vector<TriangleGoal> goals_;    ///< [triangles] targets and weights
    std::vector<Point> moves_, before_;  ///< [sites] current moves; positions before these moves
    std::optional<Relaxation> relaxation_;    ///< exists during iterations only
    std::optional<MeshTransport> transport_;  ///< created when first needed
    std::vector<double> spacings_;            ///< [sites] local spacings, in the unit frame
    MoveGuard guard_;  ///< renewed when triangles change in other ways than by steps of the polish
    Distribution result_;
};

}  // namespace ccdt
