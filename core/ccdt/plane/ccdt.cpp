// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/ccdt.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/random.h"
#include "core/ccdt/plane/construction.h"
#include "core/ccdt/plane/layered_run.h"
#include "core/ccdt/polish/polish.h"
#include "core/ccdt/polish/settings.h"
#include "core/ccdt/polish/stealth.h"

namespace ccdt {

namespace {

/// Builds the triangulations of all inks that have sites, in common iterations, and polishes the inks together.
class InkConstructions {
public:
    InkConstructions(const Domain& domain, std::span<const Density> densities, std::span<const std::size_t> sites,
                     const Options& options, const Control& control, const Retouch& retouch);

    Result<std::vector<Distribution>> execute();

private:
    bool can_be_silent() const;
    void polish();
    std::vector<std::vector<Point>> retouch(std::span<const std::vector<Point>> sites) const;
    std::vector<Distribution> collect();

    const Domain& domain_;
    const Retouch& retouch_;
    LayeredRun<Construction> inks_;
};

/// Returns the seed of an ink, given its number among the inks with sites. Number 0 keeps the seed of the options.
std::uint64_t seed_of(std::uint64_t seed, std::size_t number) {
    constexpr int kSeedBits = 53;
    return number == 0 ? seed : Random(seed, number).bits() >> (64 - kSeedBits);
}

InkConstructions::InkConstructions(const Domain& domain, std::span<const Density> densities,
                                   std::span<const std::size_t> sites, const Options& options, const Control& control,
                                   const Retouch& retouch)
    : domain_(domain), retouch_(retouch), inks_{options, control} {
    bool smooth = true;
    for (std::size_t ink = 0; ink < sites.size(); ++ink) {
        auto& layer = inks_.layers.emplace_back();
        if (sites[ink] == 0) continue;
        Options own = options;
        own.sites = sites[ink];
        own.seed = seed_of(options.seed, inks_.used.size());
        layer = std::make_unique<Construction>(domain, densities[ink], own, control);
        inks_.used.push_back(layer.get());
        smooth = smooth && densities[ink].is_smooth();
    }
    if (has_polish(options))
        inks_.settings =
            polish_settings(options.quality, inks_.used.size(), smooth, domain.is_box() || !options.fixed.empty());
    if (inks_.settings && !retouch_) inks_.settings->retouch_rounds = 0;
    if (inks_.settings && !can_be_silent()) inks_.settings->stealth_rounds = 0;
}

/// Whether the power of low frequencies can be removed; see Quality::Stealthy.
bool InkConstructions::can_be_silent() const {
    return inks_.used.size() == 1 && inks_.used.front()->is_uniform() && domain_.is_torus() &&
           inks_.options.fixed.empty() && Stealth::fits(domain_, inks_.used.front()->sites());
}

Result<std::vector<Distribution>> InkConstructions::execute() {
    if (auto started = inks_.start(); !started) return tl::unexpected(started.error());
    inks_.iterate([](Construction& construction) { construction.iterate(); });
    polish();
    for (Construction* construction : inks_.used) {
        if (auto finished = construction->finish(); !finished) return tl::unexpected(finished.error());
    }
    if (!inks_.stopping() && std::ranges::any_of(inks_.used, &Construction::has_rows)) inks_.report();
    return collect();
}

void InkConstructions::polish() {
    if (!inks_.settings || inks_.stopping()) return;
    std::vector<Polish::Layer> layers;
    for (Construction* construction : inks_.used) {
        layers.push_back(
            {&construction->polish(), &construction->mesh(),
             [construction](int passes) { construction->equalise(passes); },
             [construction](std::span<const std::array<std::uint32_t, 2>> pairs) { construction->separate(pairs); }});
    }
    Polish polish(domain_, std::move(layers), inks_.control.stop);
    const auto after = [this] { inks_.finish_round(); };
    polish.refine(*inks_.settings, inks_.control.stop, after, [this](auto sites) { return retouch(sites); });
}

/// Calls retouch_ with sites in the domain's coordinates. Returns its moves in the unit frame.
/// @param sites  [inks with sites] in the unit frame
std::vector<std::vector<Point>> InkConstructions::retouch(std::span<const std::vector<Point>> sites) const {
    const Point sides = domain_.bounds().max - domain_.bounds().min;
    const double side = std::max(sides.x, sides.y);
    std::vector<std::vector<Point>> positions(inks_.layers.size());
    std::size_t number = 0;
    for (std::size_t ink = 0; ink < inks_.layers.size(); ++ink) {
        if (!inks_.layers[ink]) continue;
        for (const Point& site : sites[number]) positions[ink].push_back(domain_.to_user(site));
        ++number;
    }
    auto moves = retouch_(positions);
    std::vector<std::vector<Point>> result;
    for (std::size_t ink = 0; ink < inks_.layers.size(); ++ink) {
        if (!inks_.layers[ink]) continue;
        for (Point& move : moves[ink]) move = 1 / side * move;
        result.push_back(std::move(moves[ink]));
    }
    return result;
}

std::vector<Distribution> InkConstructions::collect() {
    std::vector<Distribution> distributions;
    for (const auto& ink : inks_.layers) {
        distributions.push_back(ink ? ink->collect() : Distribution{});
        if (!ink) distributions.back().trace = {0};
    }
    return distributions;
}

bool is_one_grid(std::span<const Density> densities, std::span<const std::size_t> sites) {
    const Density* first = nullptr;
    for (std::size_t ink = 0; ink < sites.size(); ++ink) {
        if (sites[ink] == 0) continue;
        const Density& density = densities[ink];
        if (!first) first = &density;
        if (density.width() != first->width() || density.height() != first->height()) return false;
    }
    return true;
}

}  // namespace

Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control) {
    auto inks = distribute_inks(domain, {&density, 1}, {&options.sites, 1}, options, control);
    if (!inks) return tl::unexpected(inks.error());
    return std::move(inks->front());
}

Result<std::vector<Distribution>> distribute_inks(const Domain& domain, std::span<const Density> densities,
                                                  std::span<const std::size_t> sites, const Options& options,
                                                  const Control& control, const Retouch& retouch) {
    assert(densities.size() == sites.size());
    std::size_t all = 0;
    for (const std::size_t count : sites) all += count;
    if (!is_one_grid(densities, sites)) {
        return failure(ErrorCode::Malformed, "the densities of all inks must have one grid", "density");
    }
    Options whole = options;
    whole.sites = all;
    if (auto checked = check(whole); !checked) return tl::unexpected(checked.error());
    return InkConstructions(domain, densities, sites, options, control, retouch).execute();
}

}  // namespace ccdt
