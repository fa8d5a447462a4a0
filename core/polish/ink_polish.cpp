#include "core/polish/ink_polish.h"

#include <cmath>
#include <utility>

#include "core/polish/rounds.h"

namespace ccdt {

InkPolish::InkPolish(const Domain& domain, const Density& together, std::vector<Ink> inks, const std::stop_token& stop)
    : domain_(domain), inks_(std::move(inks)) {
    std::size_t sites = 0;
    for (const Ink& ink : inks_) sites += ink.mesh->site_count();
    places_.resize(sites);
    sites_.resize(sites);
    moves_.resize(sites);
    if (domain.is_box()) transport_.emplace(domain, together, sites, stop);
}

void InkPolish::refine(const InkPolishOptions& options, const std::stop_token& stop,
                       const std::function<void()>& after) {
    repeat(options.rounds, stop, after, [&](int round) {
        if (round % options.rounds_mesh == 0) restore_meshes(stop);
        push_apart(options.reach, options.push, options.other_reach, options.push, stop);
        if ((round + 1) % options.rounds_even == 0) even_out_each(stop);
    });
    repeat(options.even_rounds, stop, after, [&](int) {
        even_out_together(stop);
        even_out_each(stop);
    });
    repeat(options.near_rounds, stop, after,
           [&](int) { push_apart(options.nearest, options.near_push, options.other_nearest, options.push, stop); });
    repeat(options.last_rounds, stop, after, [&](int) { even_out_each(stop); });
}

/// Calls with each ink, and the moves of its sites, until it is stopped.
template <class Function>
void InkPolish::for_each(const std::stop_token& stop, Function&& function) {
    std::span<Point> moves = moves_;
    for (const Ink& ink : inks_) {
        if (stop.stop_requested()) return;
        const std::size_t sites = ink.mesh->site_count();
        function(ink, moves.first(sites));
        moves = moves.subspan(sites);
    }
}

double InkPolish::spacing(Point p) const {
    if (transport_) return transport_->spacing(p);
    return std::sqrt(domain_.unit_area() / static_cast<double>(sites_.size()));
}

/// Takes note of where all sites stand.
void InkPolish::gather() {
    std::size_t site = 0;
    for (std::uint32_t ink = 0; ink < inks_.size(); ++ink) {
        const Triangulation& mesh = *inks_[ink].mesh;
        for (std::uint32_t v = 0; v < mesh.site_count(); ++v, ++site) {
            places_[site] = mesh.point(v);
            sites_[site] = {places_[site], spacing(places_[site]), ink};
        }
    }
}

void InkPolish::restore_meshes(const std::stop_token& stop) {
    for_each(stop, [&](const Ink& ink, std::span<Point>) {
        ink.mesh->restore_delaunay(stop);
        ink.polish->begin(*ink.mesh);
    });
}

void InkPolish::push_apart(double reach, double push, double other_reach, double other_push,
                           const std::stop_token& stop) {
    gather();
    moves_ = push_inks_apart(domain_, sites_, other_reach, other_push, stop);
    for_each(stop, [&](const Ink& ink, std::span<Point> moves) {
        ink.polish->push_apart(*ink.mesh, reach, push, moves, stop);
    });
}

void InkPolish::even_out_each(const std::stop_token& stop) {
    for_each(stop, [&](const Ink& ink, std::span<Point>) { ink.polish->even_out(*ink.mesh, stop); });
}

void InkPolish::even_out_together(const std::stop_token& stop) {
    gather();
    if (!transport_ || !transport_->displacements(places_, moves_, stop)) return;
    for_each(stop, [&](const Ink& ink, std::span<Point> moves) { ink.polish->move(*ink.mesh, moves); });
}

}  // namespace ccdt
