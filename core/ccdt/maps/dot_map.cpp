// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "core/ccdt/maps/dot_ground.h"
#include "core/ccdt/maps/dot_layer.h"
#include "core/ccdt/maps/feature_area.h"
#include "core/ccdt/maps/feature_index.h"
#include "core/ccdt/plane/construction.h"
#include "core/ccdt/plane/layered_run.h"
#include "core/ccdt/polish/ink_push.h"
#include "core/ccdt/polish/schedule.h"

namespace ccdt {

namespace {

/// Returns the union of all features that have dots.
/// @param number  number of the class; none: features with dots of any class
Result<Domain> land_of(std::span<const MapFeature> features, std::optional<std::size_t> number,
                       const std::stop_token& stop) {
    std::vector<const Domain*> areas;
    for (const MapFeature& feature : features) {
        const bool has_dots = number ? feature.dots[*number] > 0
                                     : std::ranges::any_of(feature.dots, [](std::size_t dots) { return dots > 0; });
        if (has_dots) areas.push_back(&feature.area);
    }
    return Domain::united(areas, stop);
}

/// Runs each iteration for all classes in turn, and polishes all classes together.
class DotMap {
public:
    DotMap(std::span<const MapFeature> features, const Box& box, const Density& density, const Options& options,
           const Control& control)
        : features_(features),
          areas_(areas_of(features, *control.executor)),
          index_(areas_),
          map_{features, areas_, index_, box, density, options.fixed},
          run_{options, control} {}

    Result<std::vector<ClassDots>> execute();

private:
    static std::vector<FeatureArea> areas_of(std::span<const MapFeature> features, Executor& executor);
    Result<void> make_layers();
    PolishSettings settings() const;
    void polish();
    template <class Step, class... Arguments>
    void for_each(Step step, Arguments... arguments);
    bool is_any_nearer(double least) const;
    void push_apart(const Push& push);
    std::vector<Point> pushes(double reach, double push);
    std::vector<ClassDots> collect();

    std::span<const MapFeature> features_;
    std::vector<FeatureArea> areas_;
    FeatureIndex index_;
    DotGround::Map map_;
    std::optional<Domain> land_;  ///< union of the features of all classes; none if only one class has dots
    std::vector<std::unique_ptr<DotGround>> grounds_;  ///< [classes] null for classes without dots
    LayeredRun<DotLayer> run_;                         ///< its layers are the classes
};

std::vector<FeatureArea> DotMap::areas_of(std::span<const MapFeature> features, Executor& executor) {
    std::vector<FeatureArea> areas(features.size());
    executor.run(areas.size(), [&](std::size_t i) { areas[i] = FeatureArea(features[i].area); });
    return areas;
}

Result<std::vector<ClassDots>> DotMap::execute() {
    if (auto made = make_layers(); !made) return tl::unexpected(made.error());
    if (auto started = run_.start(); !started) return tl::unexpected(started.error());
    run_.iterate([this](DotLayer& layer) {
        if (run_.settings) layer.polish_between(*run_.settings);
        layer.iterate();
    });
    polish();
    return collect();
}

Result<void> DotMap::make_layers() {
    for (std::size_t number = 0; number < features_.front().dots.size(); ++number) {
        auto ground = DotGround::create(map_, number, *run_.control.executor, run_.control.stop);
        if (!ground) return tl::unexpected(ground.error());
        grounds_.emplace_back();
        auto& layer = run_.layers.emplace_back();
        if (ground->dots() == 0) continue;
        grounds_.back() = std::make_unique<DotGround>(*std::move(ground));
        auto land = land_of(features_, number, run_.control.stop);
        if (!land) return tl::unexpected(land.error());
        layer = std::make_unique<DotLayer>(*grounds_.back(), *std::move(land), run_.options, run_.control);
        run_.used.push_back(layer.get());
    }
    if (has_polish(run_.options)) run_.settings = settings();
    if (run_.used.size() < 2) return {};
    auto land = land_of(features_, std::nullopt, run_.control.stop);
    if (!land) return tl::unexpected(land.error());
    land_ = *std::move(land);
    return {};
}

PolishSettings DotMap::settings() const {
    // With fixed points, the polish is the same as for sites in a box: no relaxation follows the pushes.
    const bool is_pushed_alone = !run_.options.fixed.empty();
    const bool is_smooth = map_.density.is_smooth();
    if (run_.used.size() == 1 && is_smooth && !is_pushed_alone) return map_settings(run_.options.quality);
    PolishSettings settings = polish_settings(run_.options.quality, run_.used.size(), is_smooth, is_pushed_alone);
    settings.retouch_rounds = settings.stealth_rounds = 0;
    return settings;
}

void DotMap::polish() {
    struct Steps {
        DotMap& map;

        void push(const Push& p) { map.push_apart(p); }
        void equalise(int passes) { map.for_each(&DotLayer::equalise, passes); }
        void even_out() { map.for_each(&DotLayer::even_out); }
        void even_out_together() {}
        void restore() { map.for_each(&DotLayer::restore); }
        bool is_any_nearer(double least) { return map.is_any_nearer(least); }
        void separate(double) {}
        void retouch() {}
        void remove_low_frequencies() {}
    };
    if (!run_.settings || run_.stopping()) return;
    run_schedule(*run_.settings, Steps{*this}, run_.control.stop, [this] { run_.finish_round(); });
    for_each(&DotLayer::finish);
}

/// Calls a member function of all layers, until stopped.
template <class Step, class... Arguments>
void DotMap::for_each(Step step, Arguments... arguments) {
    for (DotLayer* layer : run_.used) {
        if (run_.stopping()) return;
        std::invoke(step, layer, arguments...);
    }
}

bool DotMap::is_any_nearer(double least) const {
    return least > 0 &&
           std::ranges::any_of(run_.used, [&](const DotLayer* layer) { return layer->least_distance() < least; });
}

void DotMap::push_apart(const Push& push) {
    const std::vector<Point> moves = pushes(push.ink_reach, push.ink_push);
    std::span<const Point> rest = moves;
    for (DotLayer* layer : run_.used) {
        const std::size_t own = rest.empty() ? 0 : layer->size();
        layer->push_apart(push.reach, push.push, rest.first(own));
        rest = rest.subspan(own);
    }
}

/// Returns the moves of all dots caused by other classes, class by class; empty if there is only one class.
std::vector<Point> DotMap::pushes(double reach, double push) {
    if (!land_) return {};
    constexpr std::size_t kDots = 4096;  // dots per task
    const double scale = std::max(land_->bounds().width(), land_->bounds().height());
    std::vector<InkSite> sites;
    std::uint32_t number = 0;
    for (std::size_t c = 0; c < run_.layers.size(); ++c) {
        if (!run_.layers[c]) continue;
        const DotLayer& layer = *run_.layers[c];
        const auto site_of = [&](std::size_t dot) {
            const Point position = layer.position(dot);
            double all = 0;
            for (const auto& ground : grounds_) {
                if (ground) all += ground->at(layer.feature_of(dot), position);
            }
            const double own = grounds_[c]->at(layer.feature_of(dot), position);
            return InkSite{land_->to_unit(position), 1 / std::sqrt(all) / scale, number, 1 / std::sqrt(own) / scale};
        };
        const std::size_t first = sites.size();
        sites.resize(first + layer.size());
        for_ranges(*run_.control.executor, layer.size(), kDots, [&](std::size_t begin, std::size_t end) {
            for (std::size_t dot = begin; dot < end; ++dot) sites[first + dot] = site_of(dot);
        });
        ++number;
    }
    auto moves = push_inks_apart(*land_, sites, reach, push, run_.control.stop);
    for (Point& move : moves) move = scale * move;
    return moves;
}

std::vector<ClassDots> DotMap::collect() {
    std::vector<ClassDots> classes;
    for (const auto& layer : run_.layers) {
        classes.push_back(layer ? layer->collect() : ClassDots{});
        if (!layer) classes.back().dots.trace = {0};
    }
    return classes;
}

}  // namespace

Result<std::vector<ClassDots>> distribute_dots(std::span<const MapFeature> features, const Box& box,
                                               const Density& density, const Options& options, const Control& control) {
    Options whole = options;
    whole.sites = 0;
    for (const MapFeature& feature : features) {
        for (const std::size_t dots : feature.dots) whole.sites += dots;
    }
    assert(whole.sites > 0);
    if (auto checked = check(whole); !checked) return tl::unexpected(checked.error());
    return DotMap(features, box, density, options, control).execute();
}

}  // namespace ccdt
