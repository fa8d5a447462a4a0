// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/choice/exchange_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/base/elementary.h"
#include "core/base/lanes.h"
#include "core/base/random.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"

namespace ccdt::choice {

namespace {

using Floats = EightLanes::Floats;
using Ints = EightLanes::Ints;
constexpr std::uint32_t kLanes = EightLanes::kCount;
constexpr float kBlocked = std::numeric_limits<float>::infinity();

/// Limit on the spacing of a pair, relative to the shorter of its two points' spacings. Up to this limit, it is the
/// geometric mean of the two spacings.
constexpr double kMaxRatio = 1.3;

constexpr float kFirstTemperature = 0.3F;  ///< in units of the pair energy at distance 0 without the core
constexpr double kAnnealedShare = 0.8;     ///< share of the passes with a temperature above 0
constexpr float kLeastGain = 1e-3F;        ///< at temperature 0; smaller gains may be due to rounding

/// Random numbers with Gumbel's distribution. The candidate with the least energy minus temperature times such a number
/// is drawn with a probability proportional to exp(-energy / temperature).
class GumbelTable {
public:
    GumbelTable() {
        for (std::size_t i = 0; i < values_.size(); ++i) {
            const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(values_.size());
            values_[i] = static_cast<float>(-elementary::log(-elementary::log(share)));
        }
    }
    float operator()(std::uint64_t bits) const { return values_[bits % kSize]; }
    float largest() const { return values_.back(); }

private:
    static constexpr std::size_t kSize = 4'096;
    std::array<float, kSize> values_{};
};

class Exchange {
public:
    Exchange(const SearchInput& input, const SearchOptions& options, std::span<std::uint8_t> is_chosen,
             Executor& executor)
        : input_(input),
          options_(options),
          over_reach_(1 / (options.energy.reach * options.energy.reach)),
          over_core_(1 / (options.energy.core_reach * options.energy.core_reach)),
          reach_(std::max(options.energy.reach, options.energy.core_reach)),
          is_torus_(input.torus.x > 0),
          cells_(is_torus_ ? CellList3(input.torus, input.positions) : CellList3(input.positions)),
          numbers_(cells_.numbers()),
          is_chosen_(is_chosen),
          executor_(executor) {
        const std::size_t n = numbers_.size();
        const auto [least, most] = std::ranges::minmax(input.spacings);
        unit_ = least;
        longest_ = most;
        axes_ = std::ranges::all_of(input.positions, [](Point3 p) { return p.z == 0; }) ? 2 : 3;
        widest_ = least == most ? 1 : kMaxRatio;
        const double range = is_torus_ ? 0x1p32 : 0x1p31;
        for (auto& each : coordinates_) each.resize(n + kLanes);
        nearness_.resize(n + kLanes);
        energy_.assign(n + kLanes, 0);
        crowding_.resize(n + kLanes);
        blocked_.assign(n + kLanes, kBlocked);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = is_torus_ ? along(input.torus, axis) : 1;
            units_[axis] = static_cast<float>(side / range / unit_);
            for (std::size_t k = 0; k < n; ++k) {
                const double position = along(input.positions[numbers_[k]], axis) / side * range;
                coordinates_[axis][k] = static_cast<std::uint32_t>(static_cast<std::int64_t>(position));
            }
        }
        for (std::uint32_t k = 0; k < n; ++k) {
            const std::uint32_t i = numbers_[k];
            nearness_[k] = static_cast<float>(unit_ / input.spacings[i]);
            crowding_[k] = input.crowding[i];
            if (is_chosen[i] == 0 && input.is_fixed[i] == 0) blocked_[k] = 0;
        }
        divide();
        set_energies();
    }

    void run(const std::stop_token& stop) {
        for (int pass = 0; pass < options_.passes && !stop.stop_requested(); ++pass) {
            const double heat = 1 - (pass + 1) / (kAnnealedShare * options_.passes);
            temperature_ = kFirstTemperature * static_cast<float>(std::max(0.0, heat));
            std::vector<std::size_t> moves(tiles_.size());
            for_tiles([&](std::size_t tile) {
                Random random(options_.seed, static_cast<std::uint64_t>(pass) << 32 | tile);
                moves[tile] = stop.stop_requested() ? 0 : pass_over(tiles_[tile], random);
            });
            if (temperature_ == 0 && std::ranges::all_of(moves, [](std::size_t count) { return count == 0; })) break;
        }
        for (std::size_t k = 0; k < numbers_.size(); ++k) {
            const std::uint32_t i = numbers_[k];
            if (input_.is_fixed[i] == 0) is_chosen_[i] = blocked_[k] == 0 ? 0 : 1;
        }
    }

private:
    using Runs = std::vector<CellList3::Run>;
    /// A range of slots_.
    struct Tile {
        std::size_t begin, end;
    };

    double spacing(std::uint32_t k) const { return input_.spacings[numbers_[k]]; }

    void find_near(std::uint32_t k, double reach, Runs& runs) const {
        cells_.find_near(input_.positions[numbers_[k]], reach * widest_ * spacing(k), runs);
    }

    /// Computes the squared distances from candidate k to eight candidates, in units of the pairs' spacings.
    CCDT_INLINE void get_squares(std::uint32_t k, std::uint32_t begin, Floats& squares) const {
        Floats distance{};
        for (std::size_t axis = 0; axis < axes_; ++axis) {
            EightLanes::Counts each;
            EightLanes::load(coordinates_[axis][begin], each);
            const Floats apart = __builtin_convertvector(Ints(each - coordinates_[axis][k]), Floats) * units_[axis];
            distance += apart * apart;
        }
        Floats other;
        EightLanes::load(nearness_[begin], other);
        constexpr auto kMaxSquare = static_cast<float>(1 / (kMaxRatio * kMaxRatio));
        const Floats own = Floats{} + nearness_[k];
        const Floats nearer = other > own ? other : own, capped = nearer * nearer * kMaxSquare, both = other * own;
        squares = distance * (both > capped ? both : capped);
    }

    CCDT_INLINE void get_energy(const Floats& squares, Floats& energy) const {
        const Floats far = 1 - squares * over_reach_, near = 1 - squares * over_core_;
        const Floats soft = far > 0 ? far * far : Floats{}, hard = near > 0 ? near * near : Floats{};
        energy = soft * soft * soft + options_.energy.core * (hard * hard);
    }

    /// Calls function(tile) for all tiles, in parallel for those of one colour.
    template <class Function>
    void for_tiles(Function&& function) {
        for (const auto& colour : colours_) {
            executor_.run(colour.second - colour.first, [&](std::size_t each) { function(colour.first + each); });
        }
    }

    /// Sets the energy of each candidate, except for its own contribution if it is chosen.
    void set_energies() {
        for (std::size_t k = 0; k < numbers_.size(); ++k) energy_[k] = -input_.wanted[numbers_[k]];
        for_tiles([&](std::size_t tile) {
            Runs runs;
            for (std::size_t each = tiles_[tile].begin; each < tiles_[tile].end; ++each) {
                const std::uint32_t k = slots_[each];
                if (is_chosen_[numbers_[k]] == 0) continue;
                find_near(k, reach_, runs);
                with_lanes([&](auto) CCDT_INLINE { add(k, 1, runs); });
            }
        });
    }

    /// Adds the pair energies of candidate k to those of the candidates around it.
    CCDT_INLINE void add(std::uint32_t k, float sign, const Runs& runs) {
        const float own = energy_[k];
        for (const auto [begin, end] : runs) {
            for (std::uint32_t first = begin; first < end; first += kLanes) {
                Floats squares, energy, sum;
                get_squares(k, first, squares);
                get_energy(squares, energy);
                EightLanes::load(energy_[first], sum);
                const Floats changed = sum + sign * energy;
                if (first + kLanes <= end) {
                    EightLanes::store(changed, energy_[first]);
                } else {
                    for (std::uint32_t lane = 0; first + lane < end; ++lane) energy_[first + lane] = changed[lane];
                }
            }
        }
        energy_[k] = own;
    }

    /// Draws the new place of chosen candidate k: itself or a free candidate near it.
    CCDT_INLINE std::uint32_t draw(std::uint32_t k, const Runs& runs, Random& random) const {
        const auto limit = static_cast<float>(options_.move_reach * options_.move_reach);
        const float own = energy_[k] + temperature_ * crowding_[k];
        std::uint32_t best = k;
        float least = temperature_ > 0 ? -temperature_ * gumbel_(random.bits()) : -kLeastGain;
        for (const auto [begin, end] : runs) {
            for (std::uint32_t first = begin; first < end; first += kLanes) {
                Floats squares, pair, energy, blocked, crowding;
                get_squares(k, first, squares);
                get_energy(squares, pair);
                EightLanes::load(energy_[first], energy);
                EightLanes::load(blocked_[first], blocked);
                EightLanes::load(crowding_[first], crowding);
                const Floats value = energy - pair + temperature_ * crowding + blocked;
                const Floats change = squares < limit ? value - own : Floats{} + kBlocked;
                const Ints is_possible = change < least + temperature_ * gumbel_.largest();
                for (std::uint32_t lane = 0; lane < kLanes && first + lane < end; ++lane) {
                    if (is_possible[lane] == 0) continue;
                    float drawn = change[lane];
                    if (temperature_ > 0) drawn -= temperature_ * gumbel_(random.bits());
                    if (drawn >= least) continue;
                    least = drawn;
                    best = first + lane;
                }
            }
        }
        return best;
    }

    /// Visits the chosen candidates of a tile. Returns the number of moves.
    std::size_t pass_over(Tile tile, Random& random) {
        Runs near, all;
        std::size_t moves = 0;
        // Each point moves once. If points could move again after a move in the direction of the list, they would
        // drift.
        std::vector<std::uint32_t> points;
        for (std::size_t each = tile.begin; each < tile.end; ++each) {
            const std::uint32_t k = slots_[each];
            if (blocked_[k] != 0 && input_.is_fixed[numbers_[k]] == 0) points.push_back(k);
        }
        for (std::size_t rest = points.size(); rest > 1; --rest)
            std::swap(points[rest - 1], points[random.bits() % rest]);
        for (const std::uint32_t k : points) {
            find_near(k, options_.move_reach, near);
            const std::uint32_t to = with_lanes([&](auto) CCDT_INLINE { return draw(k, near, random); });
            if (to == k) continue;
            find_near(k, reach_, all);
            with_lanes([&](auto) CCDT_INLINE { add(k, -1, all); });
            find_near(to, reach_, all);
            with_lanes([&](auto) CCDT_INLINE { add(to, 1, all); });
            blocked_[k] = 0;
            blocked_[to] = kBlocked;
            ++moves;
        }
        return moves;
    }

    /// Divides the candidates into tiles of a checkerboard. A move touches data up to the sum of both reaches and the
    /// length of a cell away, so tiles of one colour, which are a tile apart, do not interfere.
    void divide() {
        const Box3 box = bounds_of(input_.positions);
        const double cell =
            2 * cell_side(is_torus_ ? input_.torus : box.max - box.min, static_cast<double>(numbers_.size()));
        const double side = 2 * (options_.move_reach + reach_) * widest_ * widest_ * longest_ * 1.01 + 2 * cell;
        std::array<double, 3> counts{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double fit = std::floor((is_torus_ ? along(input_.torus, axis) : 1) / side);
            counts[axis] = std::max(1.0, std::min(2 * std::floor(fit / 2), 0x1p20));
        }
        std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(numbers_.size());
        for (std::uint32_t k = 0; k < keys.size(); ++k) {
            std::uint64_t colour = 0, tile = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double place = along(input_.positions[numbers_[k]], axis) /
                                     (is_torus_ ? along(input_.torus, axis) : 1) * counts[axis];
                const auto index = static_cast<std::uint64_t>(std::clamp(place, 0.0, counts[axis] - 1));
                colour = colour << 1 | (index & 1);
                tile = tile << 20 | index;
            }
            keys[k] = {colour << 60 | tile, k};
        }
        std::ranges::sort(keys);
        slots_.resize(keys.size());
        for (std::size_t each = 0; each < keys.size(); ++each) {
            slots_[each] = keys[each].second;
            const std::uint64_t key = keys[each].first;
            if (each > 0 && key == keys[each - 1].first) {
                ++tiles_.back().end;
                continue;
            }
            if (each == 0 || key >> 60 != keys[each - 1].first >> 60) colours_.push_back({tiles_.size(), 0});
            tiles_.push_back({each, each + 1});
            colours_.back().second = tiles_.size();
        }
    }

    const SearchInput& input_;
    const SearchOptions& options_;
    float over_reach_, over_core_;
    double reach_;  ///< reach of the pair energy, in spacings
    bool is_torus_;
    CellList3 cells_;
    std::vector<std::uint32_t> numbers_;  ///< numbers of the candidates in list order
    std::span<std::uint8_t> is_chosen_;
    Executor& executor_;
    std::size_t axes_ = 3;           ///< 2 if all candidates lie in the plane z = 0
    double unit_ = 0, longest_ = 0;  ///< least and largest spacing
    double widest_ = 1;              ///< limit on the spacing of a pair, relative to that of either point
    float temperature_ = 0;
    GumbelTable gumbel_;
    std::vector<std::uint32_t> slots_;                          ///< list positions, sorted by tile
    std::vector<Tile> tiles_;                                   ///< sorted by colour
    std::vector<std::pair<std::size_t, std::size_t>> colours_;  ///< first and last tile of each colour
    std::array<float, 3> units_{};                              ///< length of a unit of each coordinate, per unit_

    // The following vectors are in list order, with eight additional entries at the end.
    std::array<std::vector<std::uint32_t>, 3> coordinates_;
    std::vector<float> nearness_;  ///< unit_ divided by each candidate's spacing
    std::vector<float> energy_;    ///< energy that each candidate has, or would have if it were chosen
    std::vector<float> crowding_;  ///< SearchInput::crowding
    std::vector<float> blocked_;   ///< 0 for free candidates; infinity for chosen and for fixed ones
};

}  // namespace

void exchange(const SearchInput& input, const SearchOptions& options, std::span<std::uint8_t> is_chosen,
              const std::stop_token& stop, Executor& executor) {
    Exchange(input, options, is_chosen, executor).run(stop);
}

}  // namespace ccdt::choice
