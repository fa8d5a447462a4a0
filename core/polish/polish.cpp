// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/polish.h"
#include "core/mesh/flips.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ccdt {

namespace {

/// Runs rounds of a polish until stopped.
/// @param round  called with the number of the round, from 0
/// @param after  called after each round that was not stopped; may be empty
template <class Round>
void repeat(int rounds, const std::stop_token& stop, const std::function<void()>& after, Round&& round) {
    for (int i = 0; i < rounds && !stop.stop_requested(); ++i) {
        round(i);
        if (after && !stop.stop_requested()) after();
    }
}

/// Returns the density of the sites of all inks together.
Density sum_of_densities(std::span<const Polish::Layer> layers) {
    const Density& first = layers[0].steps->density();
    if (first.is_uniform()) return Density::uniform();
    std::vector<double> wanted(static_cast<std::size_t>(first.width()) * static_cast<std::size_t>(first.height()), 0);
    for (const Polish::Layer& layer : layers) {
        const Density& density = layer.steps->density();
        const double scale = static_cast<double>(layer.mesh->site_count()) / density.total();
        auto cell = wanted.begin();
        for (int row = 0; row < first.height(); ++row) {
            for (int column = 0; column < first.width(); ++column) *cell++ += scale * density.value(column, row);
        }
    }
    return Density::grid(first.width(), first.height(), std::span<const double>(wanted)).value();
}

}  // namespace

Polish::Polish(const Domain& domain, std::vector<Layer> layers, const std::stop_token& stop)
    : domain_(domain), layers_(std::move(layers)) {
    if (has_one_ink()) return;
    std::size_t sites = 0;
    for (const Layer& layer : layers_) sites += layer.mesh->site_count();
    places_.resize(sites);
    sites_.resize(sites);
    moves_.resize(sites);
    if (!domain.is_box()) return;
    density_ = sum_of_densities(layers_);
    transport_.emplace(domain, *density_, sites, stop, layers_.front().mesh->executor());
}

void Polish::refine(const PolishSettings& settings, const std::stop_token& stop, const std::function<void()>& after,
                    const Retouch& retouch) {
    constexpr double kNearPush = 0.5;  // each of the two sites moves half of the missing distance
    const auto push_near = [&] { push_apart(settings.nearest, kNearPush, settings.ink_nearest, settings.push, stop); };
    begin();
    repeat(settings.rounds, stop, after, [&](int round) {
        if (settings.mesh_every > 0 && round > 0 && round % settings.mesh_every == 0) restore_meshes(stop);
        push_apart(settings.reach, settings.push, settings.ink_reach, settings.push, stop);
        if ((round + 1) % settings.even_every == 0) even_out_each(stop);
    });
    repeat(settings.relax_rounds, stop, after, [&](int round) {
        push_apart(settings.reach, settings.push, settings.ink_reach, settings.push, stop);
        if ((round + 1) % settings.even_every == 0) {
            for (int even = 0; even < settings.relax_evens; ++even) even_out_each(stop);
        }
        equalise(settings.relax_passes, stop);
    });
    repeat(settings.even_rounds, stop, after, [&](int) {
        even_out_together(stop);
        even_out_each(stop);
        for (int push = 0; push < settings.near_pushes_per_even_round; ++push) push_near();
    });
    repeat(settings.near_rounds, stop, after, [&](int) { push_near(); });
    push_again(settings, push_near, stop);
    repeat(settings.last_rounds, stop, after, [&](int) { even_out_each(stop); });
    repeat(settings.retouch_rounds, stop, after, [&](int) { this->retouch(retouch, stop); });
    repeat(settings.stealth_rounds, stop, after,
           [&](int) { layers_.front().steps->remove_low_frequencies(*layers_.front().mesh, stop); });
}

/// Calls function(layer, moves) for each ink until stopped. `moves` is this ink's part of moves_, empty if there is one
/// ink.
template <class Function>
void Polish::for_each(const std::stop_token& stop, Function&& function) {
    std::span<Point> moves = moves_;
    for (const Layer& layer : layers_) {
        if (stop.stop_requested()) return;
        const std::size_t sites = has_one_ink() ? 0 : layer.mesh->site_count();
        function(layer, moves.first(sites));
        moves = moves.subspan(sites);
    }
}

/// Returns 1 / sqrt(density of the sites of all inks).
double Polish::spacing(Point p) const {
    if (transport_) return transport_->spacing(p);
    return std::sqrt(domain_.unit_area() / static_cast<double>(sites_.size()));
}

/// Copies the positions and spacings of the sites of all inks.
void Polish::gather() {
    std::size_t site = 0;
    for (std::uint32_t ink = 0; ink < layers_.size(); ++ink) {
        const Triangulation& mesh = *layers_[ink].mesh;
        for (std::uint32_t v = 0; v < mesh.site_count(); ++v, ++site) {
            const Point place = mesh.point(v);
            places_[site] = place;
            sites_[site] = {place, spacing(place), ink, layers_[ink].steps->spacing(place)};
        }
    }
}

void Polish::begin() {
    for (const Layer& layer : layers_) layer.steps->begin(*layer.mesh);
}

bool Polish::is_any_nearer(double least) {
    return least > 0 && std::ranges::any_of(
                            layers_, [&](const Layer& layer) { return layer.steps->find_nearer(*layer.mesh, least); });
}

/// Repeats a push on new triangulations while any two sites are too near. Pushes cannot separate two sites that are
/// enclosed by other sites or by the border in a narrow neck. One of two such sites is relocated.
void Polish::push_again(const PolishSettings& settings, const std::function<void()>& push,
                        const std::stop_token& stop) {
    for (int round = 0; round < settings.max_retries && !stop.stop_requested() && is_any_nearer(settings.least);
         ++round) {
        for (const Layer& layer : layers_) {
            if (round < settings.relocate_after || !layer.separate) continue;
            layer.separate(layer.steps->near_pairs(*layer.mesh, settings.least));
        }
        restore_meshes(stop);
        push();
    }
}

void Polish::restore_meshes(const std::stop_token& stop) {
    for_each(stop, [&](const Layer& layer, std::span<Point>) { restore_delaunay(*layer.mesh, stop); });
    begin();
}

void Polish::push_apart(double reach, double push, double ink_reach, double ink_push, const std::stop_token& stop) {
    if (!has_one_ink()) {
        gather();
        moves_ = push_inks_apart(domain_, sites_, ink_reach, ink_push, stop);
    }
    for_each(stop, [&](const Layer& layer, std::span<Point> moves) {
        layer.steps->push_apart(*layer.mesh, reach, push, moves, stop);
    });
}

void Polish::equalise(int passes, const std::stop_token& stop) {
    for_each(stop, [&](const Layer& layer, std::span<Point>) { layer.equalise(passes); });
    begin();
}

void Polish::even_out_each(const std::stop_token& stop) {
    for_each(stop, [&](const Layer& layer, std::span<Point>) { layer.steps->even_out(*layer.mesh, stop); });
}

/// Evens out the sites of all inks together, like the sites of a single ink. Does nothing in polygons.
void Polish::even_out_together(const std::stop_token& stop) {
    if (!transport_) return;
    gather();
    if (!transport_->displacements(places_, moves_, stop)) return;
    for_each(stop, [&](const Layer& layer, std::span<Point> moves) { layer.steps->move(*layer.mesh, moves); });
}

void Polish::retouch(const Retouch& retouch, const std::stop_token& stop) {
    std::vector<std::vector<Point>> sites;
    for (const Layer& layer : layers_) {
        const auto all = std::span<const Point>(layer.mesh->points()).first(layer.mesh->site_count());
        sites.emplace_back(all.begin(), all.end());
    }
    const auto moves = retouch(sites);
    for (std::size_t ink = 0; ink < layers_.size() && !stop.stop_requested(); ++ink)
        layers_[ink].steps->move(*layers_[ink].mesh, moves[ink]);
}

}  // namespace ccdt
