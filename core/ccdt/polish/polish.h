// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/polish/ink_push.h"
#include "core/ccdt/polish/mesh_polish.h"
#include "core/ccdt/polish/settings.h"
#include "core/ccdt/polish/transport.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Polishes the sites of one or several inks. Rounds that push near sites apart alternate with rounds that remove long
/// waves of density error. Sites of different inks are pushed apart as well. Long waves are removed both from each ink
/// and from all inks taken together.
class Polish {
public:
    /// The sites of one ink.
    struct Layer {
        MeshPolish* steps = nullptr;
        Triangulation* mesh = nullptr;
        /// Restores the Delaunay property of the mesh, and makes the capacities of its triangles more equal by a number
        /// of passes. May be empty if the settings have no relax rounds.
        std::function<void(int passes)> equalise;
        /// Relocates one site of each pair of near sites in a polygon to a position with more space. May be empty.
        std::function<void(std::span<const std::array<std::uint32_t, 2>> pairs)> separate = {};
    };

    /// Function that computes moves of the sites of all inks.
    /// @param sites  [layers] in the unit frame
    /// @returns      [layers][sites]
    using Retouch = std::function<std::vector<std::vector<Point>>(std::span<const std::vector<Point>> sites)>;

    /// @param layers  [n >= 1], with densities on one common grid; all must outlive this object
    /// @param stop    polled regularly; after a stop the object must not be used
    Polish(const Domain& domain, std::vector<Layer> layers, const std::stop_token& stop = {});

    /// Moves the sites of all meshes. All triangles stay counter-clockwise; the Delaunay property is lost.
    /// @param stop     polled several times per round
    /// @param after    called after each round that was not stopped; may be empty
    /// @param retouch  called in each retouch round; may be empty if there is none
    ///
    /// Deterministic. O(sites log sites) per round.
    void refine(const PolishSettings& settings, const std::stop_token& stop, const std::function<void()>& after = {},
                const Retouch& retouch = {});

private:
    bool has_one_ink() const { return layers_.size() == 1; }
    template <class Function>
    void for_each(const std::stop_token& stop, Function&& function);
    double spacing(Point p) const;
    void gather();
    void begin();
    bool is_any_nearer(double least);
    void restore_meshes(const std::stop_token& stop);
    void push_apart(double reach, double push, double ink_reach, double ink_push, const std::stop_token& stop);
    void equalise(int passes, const std::stop_token& stop);
    void even_out_each(const std::stop_token& stop);
    void even_out_together(const std::stop_token& stop);
    void retouch(const Retouch& retouch, const std::stop_token& stop);

    const Domain& domain_;
    std::vector<Layer> layers_;

    // Data of the sites of all inks, one ink after the other; empty if there is only one ink.
    std::optional<Density> density_;
    std::optional<Transport> transport_;
    std::vector<Point> positions_;  ///< [sites] positions in the unit frame
    std::vector<InkSite> sites_;    ///< [sites] sites with their inks
    std::vector<Point> moves_;      ///< [sites]
};

}  // namespace ccdt
