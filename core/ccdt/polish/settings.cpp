// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/settings.h"

#include <cassert>

namespace ccdt {

namespace {

/// Settings of the two qualities Standard and Best.
struct Row {
    PolishSettings standard, best;
};

// Benchmark TorusPattern. More rounds or a longer reach increase the least distance, but raise the peak of the
// spectrum. Fewer even rounds, or a longer reach of near pushes, leave long waves. Without near rounds, some pairs stay
// close.
constexpr Row kSmooth{
    {.rounds = 5, .reach = 0.93, .push = 0.4, .even_rounds = 1, .near_rounds = 4, .nearest = 0.84},
    {.rounds = 40, .reach = 0.87, .push = 0.5, .even_rounds = 4, .near_rounds = 4, .nearest = 0.84},
};
// Benchmark CountryPattern. Pushes that reach all neighbours, followed by relaxation, increase distances and make
// capacities more equal; more rounds improve both further. Removing waves half as often before the relaxation leaves
// waves among fjords a decibel stronger. Removing waves at the end makes capacities less equal where borders are
// ragged: with one more such round, they would be less equal than in a draft. A longer reach of near pushes increases
// distances, but makes capacities less equal.
constexpr Row kPolygon{
    {.reach = 1.1,
     .push = 1,
     .relax_rounds = 3,
     .relax_passes = 4,
     .relax_evens = 2,
     .even_rounds = 1,
     .near_pushes_per_even_round = 2,
     .nearest = 0.84,
     .least = 0.72,
     .max_retries = 8,
     .relocate_after = 2},
    {.reach = 1.1,
     .push = 1,
     .relax_rounds = 12,
     .relax_passes = 5,
     .relax_evens = 2,
     .even_rounds = 4,
     .near_pushes_per_even_round = 2,
     .nearest = 0.85,
     .least = 0.72,
     .max_retries = 8,
     .relocate_after = 3},
};
// In dot maps no dot may cross a border, so even rounds push dots onto borders. With fewer or weaker near pushes at the
// end, one dot in a hundred has a neighbour nearer than 0.75 of the hexagonal distance: test_dot_maps.py, Counties.
constexpr Row kMap{
    {.early = 2,
     .reach = 0.93,
     .push = 0.4,
     .even_rounds = 1,
     .near_rounds = 4,
     .nearest = 0.82,
     .least = 0.72,
     .max_retries = 3},
    {.rounds = 10,
     .even_every = 10,
     .reach = 0.93,
     .push = 0.4,
     .relax_rounds = 9,
     .relax_passes = 3,
     .relax_pushes = false,
     .even_rounds = 2,
     .near_rounds = 4,
     .nearest = 0.82},
};
// Benchmark PictureTone. Without even rounds, or with a longer reach of near pushes, the error of tone is larger. Twice
// as many of the first rounds (`rounds`) gain almost nothing.
constexpr Row kVarying{
    {.rounds = 4, .reach = 0.93, .push = 0.4, .even_rounds = 3, .near_rounds = 2, .nearest = 0.72},
    {.rounds = 20, .reach = 0.93, .push = 0.4, .even_rounds = 10, .near_rounds = 2, .nearest = 0.72},
};
// Benchmark InksPattern. Shorter reaches between inks, or fewer rounds, reduce the distance between inks. If the meshes
// are not made Delaunay again (`mesh_every`), this distance is 2 % smaller where the density varies; doing so in each
// round gains no more. The last even round (`last_rounds`) reduces this distance as well, but without it the tone of
// each ink is lost: test DistributeInks.KeepsTheToneOfEachInk. More retouch rounds gain little: test_colour.py,
// Likeness.
constexpr Row kInks{
    {.rounds = 10,
     .even_every = 2,
     .mesh_every = 5,
     .reach = 0.93,
     .push = 0.3,
     .ink_reach = 0.9,
     .even_rounds = 2,
     .near_rounds = 3,
     .nearest = 0.72,
     .ink_nearest = 0.73,
     .last_rounds = 1,
     .retouch_rounds = 2},
    {.rounds = 30,
     .even_every = 1,
     .mesh_every = 5,
     .reach = 0.93,
     .push = 0.3,
     .ink_reach = 0.9,
     .even_rounds = 4,
     .near_rounds = 3,
     .nearest = 0.72,
     .ink_nearest = 0.73,
     .last_rounds = 1,
     .retouch_rounds = 6},
};

/// Limit on stealth rounds. The first round leaves a power of about 1e-7, the second 1e-11, the third only rounding
/// errors.
constexpr int kStealthRounds = 4;

}  // namespace

PolishSettings polish_settings(Quality quality, std::size_t inks, bool smooth, bool in_box) {
    assert(quality != Quality::Draft);
    const Row& row = inks > 1 ? kInks : !smooth ? kVarying : in_box ? kSmooth : kPolygon;
    PolishSettings settings = quality == Quality::Standard ? row.standard : row.best;
    if (quality == Quality::Stealthy) settings.stealth_rounds = kStealthRounds;
    return settings;
}

PolishSettings surface_settings(Quality quality) {
    assert(quality != Quality::Draft);
    PolishSettings settings = quality == Quality::Best ? kPolygon.best : kPolygon.standard;
    // No edge joins two sites that face each other in a fold. Only the search for sites nearer than this finds them.
    settings.least = 0.8;
    settings.max_retries = 30;
    // Relocated sites leave long waves, which last rounds remove. On nefertiti, a model of 50,000 vertices, with 16,384
    // sites and quality `best`, the power of the lowest 401 modes is up to 5 dB higher with one last round than with
    // four.
    settings.last_rounds = quality == Quality::Best ? 4 : 1;
    return settings;
}

PolishSettings map_settings(Quality quality) {
    assert(quality != Quality::Draft);
    return quality == Quality::Best ? kMap.best : kMap.standard;
}

}  // namespace ccdt
