// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/polish.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/ccdt/polish/schedule.h"
#include "core/mesh/flips.h"

namespace ccdt {

namespace {

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
    positions_.resize(sites);
    sites_.resize(sites);
    moves_.resize(sites);
    if (!domain.is_box()) return;
    density_ = sum_of_densities(layers_);
    transport_.emplace(domain, *density_, sites, stop, layers_.front().mesh->executor());
}

void Polish::refine(const PolishSettings& settings, const std::stop_token& stop, const std::function<void()>& after,
                    const Retouch& retouch) {
    struct Steps {
        Polish& polish;
        const std::stop_token& stop;
        const Retouch& moves;

        void push(const Push& p) { polish.push_apart(p.reach, p.push, p.ink_reach, p.ink_push, stop); }
        void equalise(int passes) { polish.equalise(passes, stop); }
        void even_out() { polish.even_out_each(stop); }
        void even_out_together() { polish.even_out_together(stop); }
        void restore() { polish.restore_meshes(stop); }
        bool is_any_nearer(double least) { return polish.is_any_nearer(least); }
        void separate(double least) {
            for (const Layer& layer : polish.layers_) {
                if (layer.separate) layer.separate(layer.steps->near_pairs(*layer.mesh, least));
            }
        }
        void retouch() { polish.retouch(moves, stop); }
        void remove_low_frequencies() {
            const Layer& layer = polish.layers_.front();
            layer.steps->remove_low_frequencies(*layer.mesh, stop);
        }
    };
    begin();
    run_schedule(settings, Steps{*this, stop, retouch}, stop, after);
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
            const Point position = mesh.point(v);
            positions_[site] = position;
            sites_[site] = {position, spacing(position), ink, layers_[ink].steps->spacing(position)};
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
    if (!transport_->displacements(positions_, moves_, stop)) return;
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
