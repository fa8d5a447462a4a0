#pragma once

#include <array>
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
#include "core/polish/ink_push.h"
#include "core/polish/mesh_polish.h"
#include "core/polish/settings.h"
#include "core/polish/transport.h"

namespace ccdt {

/// Polishes the sites of one ink or of several. Rounds that push near sites apart alternate with rounds that undo long
/// waves of density error; sites of different inks keep apart as well, and long waves are evened out of each ink and of
/// all together.
class Polish {
public:
    /// The sites of one ink.
    struct Layer {
        MeshPolish* steps = nullptr;
        Triangulation* mesh = nullptr;
        std::function<void(int passes)> equalise;  ///< makes the mesh Delaunay and its triangles more equal; may be
                                                   ///< empty if no settings want it
        /// Separates pairs of near sites of a polygon: one of each is taken to where there is more room; may be empty:
        /// none is.
        std::function<void(std::span<const std::array<std::uint32_t, 2>> pairs)> separate = {};
    };

    /// Computes moves of all sites of several inks.
    /// @param sites  [layers] in the unit frame
    /// @returns      [layers][sites]
    using Retouch = std::function<std::vector<std::vector<Point>>(std::span<const std::vector<Point>> sites)>;

    /// @param layers  [n >= 1], their densities on one grid; all must outlive this
    /// @param stop    asked now and then; leaves what is of no use
    Polish(const Domain& domain, std::vector<Layer> layers, const std::stop_token& stop = {});

    /// Moves the sites of all meshes. All triangles stay counter-clockwise; the Delaunay property is lost.
    /// @param stop     asked several times a round
    /// @param after    called after each round that was not stopped; may be empty
    /// @param retouch  called in each round that retouches; may be empty if there is none
    /// Same input, same bytes. O(sites log sites) a round.
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
    void push_again(const PolishSettings& settings, const std::function<void()>& push, const std::stop_token& stop);
    void restore_meshes(const std::stop_token& stop);
    void push_apart(double reach, double push, double ink_reach, double ink_push, const std::stop_token& stop);
    void equalise(int passes, const std::stop_token& stop);
    void even_out_each(const std::stop_token& stop);
    void even_out_together(const std::stop_token& stop);
    void retouch(const Retouch& retouch, const std::stop_token& stop);

    const Domain& domain_;
    std::vector<Layer> layers_;

    // Of all inks together, one after the other; empty if there is one ink alone.
    std::optional<Density> density_;
    std::optional<Transport> transport_;
    std::vector<Point> places_;   ///< [sites]
    std::vector<InkSite> sites_;  ///< [sites]
    std::vector<Point> moves_;    ///< [sites]
};

}  // namespace ccdt
