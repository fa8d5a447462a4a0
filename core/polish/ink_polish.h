#pragma once

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
#include "core/polish/polish.h"
#include "core/polish/transport.h"

namespace ccdt {

/// Distances are over that of neighbours in a hexagonal grid: of an ink's own sites, or of all inks' together.
/// Measured on flat tints and photographs: these keep an ink nearly as even as it is alone, while the dots of
/// different inks lie about as far apart as those of a halftone made of all of them.
struct InkPolishOptions {
    int rounds = 10;              ///< that push near sites apart, own ones and those of other inks
    int rounds_even = 2;          ///< rounds after which each ink's long waves are evened out
    int rounds_mesh = 5;          ///< rounds after which the neighbours are found anew
    int even_rounds = 2;          ///< then, that only even out, all inks together and each by itself
    int near_rounds = 3;          ///< then, that only push the nearest ones
    int last_rounds = 1;          ///< last, that even out what these have left behind in each ink
    double reach = 0.93;          ///< distance below which sites of an ink are pushed
    double push = 0.3;            ///< share of what is missing by which each of two sites moves
    double other_reach = 0.9;     ///< distance below which sites of different inks are pushed
    double nearest = 0.72;        ///< reach of the near rounds,
    double other_nearest = 0.66;  ///< and that between different inks
    double near_push = 0.5;       ///< their push within an ink

    int all_rounds() const { return rounds + even_rounds + near_rounds + last_rounds; }
};

/// Polishes several inks at once, as Polish does one, such that sites of different inks keep apart.
class InkPolish {
public:
    struct Ink {
        Polish* polish = nullptr;
        Triangulation* mesh = nullptr;
    };

    /// @param together  the density of all inks' sites
    /// All must outlive this.
    /// @param stop  asked now and then; leaves what is of no use
    InkPolish(const Domain& domain, const Density& together, std::vector<Ink> inks, const std::stop_token& stop = {});

    /// Moves the sites of all meshes. All triangles stay counter-clockwise; the Delaunay property is lost.
    /// @param stop   asked several times a round
    /// @param after  called after each round that was not stopped; may be empty
    /// Same input, same bytes. O(sites log sites) a round.
    void refine(const InkPolishOptions& options, const std::stop_token& stop, const std::function<void()>& after = {});

private:
    template <class Function>
    void for_each(const std::stop_token& stop, Function&& function);
    void gather();
    double spacing(Point p) const;
    void restore_meshes(const std::stop_token& stop);
    void push_apart(double reach, double push, double other_reach, double other_push, const std::stop_token& stop);
    void even_out_each(const std::stop_token& stop);
    void even_out_together(const std::stop_token& stop);

    const Domain& domain_;
    std::vector<Ink> inks_;
    std::optional<Transport> transport_;  ///< of all sites together
    std::vector<Point> places_;           ///< [sites of all inks, one after the other]
    std::vector<InkSite> sites_;          ///< the same
    std::vector<Point> moves_;            ///< the same
};

}  // namespace ccdt
