// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/baselines/periodic_images.h"
#include "core/baselines/site_tree.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Assigns the same number of samples to each site, and swaps samples until no swap lowers the energy. The energy is
/// the sum of squared distances from samples to their sites, where each site is the centroid of its samples.
///
/// For two cells at a time, the samples with the largest gains are swapped as long as there is a gain. The result is
/// the best division of the two cells' samples between the two sites. A pair of cells is considered only if one of the
/// two cells could have a sample nearer to the other site, and if at least one has changed since the pair was last
/// considered. Source: Balzer, Schloemer, Deussen 2009, section 3 and algorithm 1. Departures, for speed as in Li,
/// Nehab, Wei, Sander, Fu 2010: the choice of pairs; samples are initially assigned to the nearest site with free
/// capacity, not to an arbitrary one; centroids are updated after each swap, not after each round.
class EqualCells {
public:
    /// @param samples  [sites * capacity]; on a torus: within the torus's box
    /// @param sites    [n >= 1] initial positions
    /// @param stop     polled regularly; after a stop samples may be missing and the cells must not be used
    EqualCells(std::vector<Point> samples, std::span<const Point> sites, const PeriodicImages& images,
               const std::stop_token& stop);

    /// Considers every pair of cells once. The energy never increases; after finitely many sweeps, no swap lowers it.
    /// @param stop  polled every few sites; ends the sweep
    /// @returns     whether anything was swapped
    bool sweep(const std::stop_token& stop);

    /// Returns the centroid of each site's samples [sites]; on a torus: within the torus's box.
    std::span<const Point> centroids() const { return sites_; }

    /// Returns the samples of a site [capacity].
    std::span<const Point> cell(std::size_t site) const { return {&samples_[site * capacity_], capacity_}; }

    double energy() const;

private:
    /// A sample, and the decrease of the energy if the sample moves to the other site.
    struct Offer {
        double gain;
        std::uint32_t sample;
    };

    bool assign_samples(std::span<const Point> samples, const std::stop_token& stop);
    bool has_changed_lately(std::uint32_t site) const { return changed_[site] + 1 >= sweeps_; }
    bool swap(std::uint32_t first, std::uint32_t second);
    double find_gains(std::uint32_t from, std::uint32_t to, std::vector<double>& gains) const;
    bool is_clear_of_seams(std::uint32_t from, std::uint32_t to) const;
    void find_offers(std::uint32_t site, const std::vector<double>& gains, double least,
                     std::vector<Offer>& offers) const;
    void update_site(std::uint32_t site);

    PeriodicImages images_;
    std::size_t capacity_;
    std::vector<Point> sites_;
    std::vector<Point> samples_;          ///< [sites * capacity] grouped by site
    std::vector<double> radii_;           ///< [sites] distance to the farthest of the site's samples
    std::vector<std::uint32_t> changed_;  ///< [sites] last sweep in which the site swapped samples
    std::uint32_t sweeps_ = 0;

    // For the current two sites: squared distance of each sample from its own site, minus its squared distance from the
    // other site.
    std::vector<double> first_gains_, second_gains_;
    std::vector<Offer> first_offers_, second_offers_;
};

}  // namespace ccdt
