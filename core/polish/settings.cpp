#include "core/polish/settings.h"

#include <cassert>

namespace ccdt {

namespace {

/// Settings of both qualities that polish.
struct Row {
    PolishSettings standard, best;
};

// More rounds, or a longer reach, make the spectrum of one ink oscillate more. Several inks stay nearly as even as each
// is alone, while their dots lie about as far apart as those of a halftone made of all of them.
constexpr Row kUniform{
    {.rounds = 5, .reach = 0.93, .push = 0.4, .even_rounds = 1, .near_rounds = 4, .nearest = 0.84},
    {.rounds = 40, .reach = 0.87, .push = 0.5, .even_rounds = 4, .near_rounds = 4, .nearest = 0.84},
};
constexpr Row kVarying{
    {.rounds = 4, .reach = 0.93, .push = 0.4, .even_rounds = 3, .near_rounds = 2, .nearest = 0.72},
    {.rounds = 20, .reach = 0.93, .push = 0.4, .even_rounds = 10, .near_rounds = 2, .nearest = 0.72},
};
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
     .ink_nearest = 0.66,
     .last_rounds = 1},
    {.rounds = 30,
     .even_every = 1,
     .mesh_every = 5,
     .reach = 0.93,
     .push = 0.3,
     .ink_reach = 0.9,
     .even_rounds = 4,
     .near_rounds = 3,
     .nearest = 0.72,
     .ink_nearest = 0.66,
     .last_rounds = 1},
};

}  // namespace

PolishSettings polish_settings(Quality quality, std::size_t inks, bool uniform) {
    assert(quality != Quality::Draft);
    const Row& row = inks > 1 ? kInks : uniform ? kUniform : kVarying;
    return quality == Quality::Best ? row.best : row.standard;
}

}  // namespace ccdt
