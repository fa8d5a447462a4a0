// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace ccdt {

/// Amount of work spent on the pattern after the triangles' capacities are equal.
enum class Quality {
    Draft,     ///< no polish: triangles of equal capacity, as in the paper
    Standard,  ///< pushes near neighbours apart and removes long waves
    Best,      ///< works like Standard with more rounds: takes a few times as long
    /// Works like Best, then removes all power from the low frequencies (Stealth). The last step needs a torus of
    /// uniform density that is wide enough, with one ink and no fixed points.
    Stealthy,
};

/// Schedule of a polish, in order of execution, and the strength of its steps. Every reach is relative to the hexagonal
/// distance of the sites that are pushed: of the ink's own sites for pushes within an ink, of the sites of all inks for
/// pushes between inks. "Waves" are long waves.
struct PolishSettings {
    /// For dot maps: number of iterations, up to the last one, that begin with a push and a removal of waves.
    int early = 0;
    int rounds = 0;                      ///< rounds that push near sites apart and remove long waves
    int even_every = 1;                  ///< rounds from one removal of waves to the next
    int mesh_every = 0;                  ///< rounds from one Delaunay triangulation to the next; 0: none
    double reach = 0;                    ///< distance below which neighbours of one ink are pushed
    double push = 0;                     ///< share of the missing distance by which each of the two sites moves
    double ink_reach = 0;                ///< distance below which sites of different inks are pushed
    int relax_rounds = 0;                ///< next step: rounds that also equalise the triangles' capacities
    int relax_passes = 0;                ///< passes of relaxation in each relax round
    bool relax_pushes = true;            ///< whether relax rounds begin with a push
    int relax_evens = 1;                 ///< number of removals of waves in each relax round
    int even_rounds = 0;                 ///< next step: even rounds, which remove waves
    int near_pushes_per_even_round = 0;  ///< near pushes after each even round
    int near_rounds = 0;                 ///< next step: near pushes alone, which move too few sites to create waves
    double nearest = 0;                  ///< reach of a near push within an ink
    double ink_nearest = 0;              ///< reach of a near push between inks
    /// Near pushes are repeated on new triangulations while any two sites of an ink are closer than this distance,
    /// which is relative to the hexagonal distance.
    double least = 0;
    int max_retries = 0;  ///< limit on the repetitions of near pushes (see `least`)
    /// Number of repetitions of near pushes without relocation. In polygons, each further repetition begins by
    /// relocating one site of every pair that is too close.
    int relocate_after = 0;
    /// Next step: even rounds, which remove waves that the pushes have left. Near pushes are repeated after each round.
    int last_rounds = 0;
    int retouch_rounds = 0;  ///< next step: rounds of moves that the caller computes from all inks together
    int stealth_rounds = 0;  ///< last step: maximum number of rounds that remove the power of low frequencies

    int all_rounds() const {
        return rounds + relax_rounds + even_rounds + near_rounds + last_rounds + retouch_rounds + stealth_rounds;
    }
};

/// Returns the schedule for a quality.
/// @param quality  not Draft, which has no polish
/// @param smooth   whether the density is smooth; unused if there are several inks
/// @param in_box   whether the domain is a box or a torus; used only for one ink with a smooth density
PolishSettings polish_settings(Quality quality, std::size_t inks, bool smooth, bool in_box = true);

/// Returns the schedule for a surface.
/// @param quality  Standard or Best
PolishSettings surface_settings(Quality quality);

/// Returns the schedule for a dot map of one class with a smooth density.
PolishSettings map_settings(Quality quality);

}  // namespace ccdt
