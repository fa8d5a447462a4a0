// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/placement.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/ccdt/plane/interior_sampler.h"
#include "core/mesh/insertion.h"
#include "core/mesh/insertion_steps.h"
#include "core/mesh/inside.h"

namespace ccdt {

namespace {

/// Inserts sites at positions drawn by StartSites, or else anywhere with space.
class Placement {
public:
    Placement(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
              std::vector<std::size_t> vacancies, std::uint64_t seed, double margin)
        : mesh_(mesh), first_(first), start_(start), vacancies_(std::move(vacancies)), seed_(seed), margin_(margin) {}

    /// Places sites, given in ascending order.
    /// @returns  false if there is no position for one of the sites; after a stop the result must not be used
    bool position(std::span<const std::uint32_t> sites, const std::stop_token& stop) {
        const auto draw = [this](std::uint32_t site, int attempt) { return this->draw(site, attempt); };
        if (vacancies_.empty()) {
            const auto remaining = insert_sites(mesh_, sites, draw, kAttempts, margin_, stop);
            return std::ranges::all_of(remaining,
                                       [&](auto site) { return stop.stop_requested() || place_anywhere(site); });
        }
        return std::ranges::all_of(sites, [&](auto site) { return stop.stop_requested() || position(site); });
    }

private:
    /// Number of attempts to place a site. If the domain covers half of a cell, all fail with a probability of 2^-16.
    static constexpr int kAttempts = 16;

    Point draw(std::uint32_t site, int attempt) const {
        return attempt == 0 && !first_.empty() ? first_[site] : start_.draw(site, attempt);
    }

    bool position(std::uint32_t site) {
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            if (insert(site, draw(site, attempt))) return true;
        }
        return place_anywhere(site);
    }

    /// Places a site whose own cell has almost no usable area.
    bool place_anywhere(std::uint32_t site) {
        while (!vacancies_.empty()) {
            const auto most = std::ranges::max_element(vacancies_);
            if (*most == 0) {
                vacancies_.clear();
            } else if (place_in(static_cast<std::uint32_t>(most - vacancies_.begin()), site)) {
                return true;
            } else {
                *most = 0;
            }
        }
        return place_in(Triangulation::kNone, site);
    }

    bool insert(std::uint32_t site, Point p) {
        if (vacancies_.empty()) return insert_site(mesh_, site, p, margin_);
        const std::uint32_t part = part_at(mesh_, p);
        if (part == Triangulation::kNone || vacancies_[part] == 0 || !insert_site(mesh_, site, p, margin_))
            return false;
        --vacancies_[part];
        return true;
    }

    /// Places a site anywhere in a part; for kNone, anywhere in the domain.
    bool place_in(std::uint32_t part, std::uint32_t site) {
        constexpr int kTries = 1000;
        constexpr std::uint64_t kStream = 0x616e797768657265;  // differs from the streams of StartSites
        if (!interior_ || part_ != part) interior_.emplace(inside_triangles(mesh_, part_ = part));
        Random random(seed_ ^ kStream, site);
        for (int attempt = 0; attempt < kTries; ++attempt) {
            if (insert(site, interior_->draw(random))) return true;
        }
        return false;
    }

    Triangulation& mesh_;
    std::span<const Point> first_;
    const StartSites& start_;
    std::vector<std::size_t> vacancies_;
    std::uint64_t seed_;
    double margin_;
    std::optional<InteriorSampler> interior_;  ///< draws points in part number part_
    std::uint32_t part_ = Triangulation::kNone;
};

}  // namespace

std::optional<Error> place_sites(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
                                 std::vector<std::size_t> vacancies, std::uint64_t seed, double margin,
                                 const std::stop_token& stop) {
    const std::size_t sites = mesh.free_count();
    Placement placement(mesh, first, start, std::move(vacancies), seed, margin);
    const bool placed =
        for_insertion_steps(sites, [&](auto step) { return placement.position(step, stop) && !stop.stop_requested(); });
    if (stop.stop_requested()) return Error{ErrorCode::Stopped, "stopped before there was a result", ""};
    if (placed) return std::nullopt;
    return Error{ErrorCode::Unusable,
                 "the domain is too thin to hold " + std::to_string(sites) + " sites strictly inside", "sites"};
}

}  // namespace ccdt
