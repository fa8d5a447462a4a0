#pragma once

#include <cstddef>

namespace ccdt {

/// Work done on the pattern once the triangles' capacities are equal.
enum class Quality {
    Draft,     ///< none: triangles of equal capacity, as in the paper
    Standard,  ///< near neighbours are pushed apart and long waves evened out
    Best,      ///< the same for longer: a few times the time
    Stealthy,  ///< then no power at all is left in the low frequencies of a torus of uniform density (Stealth), if that
               ///< is wide enough, has one ink and no fixed points; of other domains as Best
};

/// Schedule of a polish, in the order in which it is done, and the strength of its steps. Reaches are over the distance
/// of neighbours in a hexagonal grid: of an ink's own sites, or of all inks' together.
struct PolishSettings {
    int early = 0;           ///< in maps of dots alone, iterations, the last ones, that begin with such a round
    int rounds = 0;          ///< that push near sites apart and even out long waves
    int even_every = 1;      ///< of so many rounds only the last evens out, here and where triangles are made equal
    int mesh_every = 0;      ///< of these rounds after which neighbours are found anew; 0: never
    double reach = 0;        ///< distance below which neighbours of one ink are pushed
    double push = 0;         ///< share of what is missing by which each of the two moves
    double ink_reach = 0;    ///< distance below which sites of different inks are pushed
    int relax_rounds = 0;    ///< then, that push and even out as well, and make triangles equal again
    int relax_passes = 0;    ///< of the relaxation in each of these
    int relax_evens = 1;     ///< how often these even out where they do
    int even_rounds = 0;     ///< then, that even out,
    int even_pushes = 0;     ///< each followed by so many pushes of the nearest sites
    int near_rounds = 0;     ///< then, that only push the nearest sites: too few to make waves
    double nearest = 0;      ///< their reach within an ink,
    double ink_nearest = 0;  ///< and between inks
    double least = 0;        ///< distance of neighbours below which they are pushed so again, found anew each time,
    int most_again = 0;      ///< so often at most;
    int take_after = 0;  ///< after so many of these, in polygons, each begins by relocating one of two that are as near
    int last_rounds = 0;     ///< then, that even out what these have left behind
    int retouch_rounds = 0;  ///< last, of moves that the caller chooses by what is seen of all inks together
    int stealth_rounds = 0;  ///< at most, that silence low frequencies

    int all_rounds() const {
        return rounds + relax_rounds + even_rounds + near_rounds + last_rounds + retouch_rounds + stealth_rounds;
    }
};

/// @param quality  not Draft, which has no polish
/// @param smooth   whether the density is, if there is one ink alone
/// @param in_box   whether the domain is a box or a torus
PolishSettings polish_settings(Quality quality, std::size_t inks, bool smooth, bool in_box = true);

/// Those of a map of dots of one class whose density is smooth.
PolishSettings map_settings(Quality quality);

}  // namespace ccdt
