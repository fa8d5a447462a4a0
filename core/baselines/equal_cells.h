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

/// Samples dealt out to sites, the same number to each, and swapped until that lowers the energy no more: the sum of
/// the squared distances from the samples to their sites, each site being the centroid of its samples.
///
/// Two cells at a time, the samples are swapped that gain most by it, as long as there is a gain: of all ways to divide
/// the two cells' samples between their sites, the best. Only pairs are looked at of which one could have a sample
/// nearer to the other's site, and that have changed since they were looked at last.
/// Source: Balzer, Schloemer, Deussen 2009, section 3 and algorithm 1. Departures, to the end of Li, Nehab, Wei,
/// Sander, Fu 2010, who make it fast: the choice of pairs; samples are first dealt to the nearest site that wants more
/// instead of to any; centroids follow each swap instead of each round.
class EqualCells {
public:
    /// @param samples  [sites * capacity]; on a torus within its box
    /// @param sites    [n >= 1] where each is at first
    /// @param stop     asked now and then; once it is requested, samples may be missing and the cells not to be used
    EqualCells(std::vector<Point> samples, std::span<const Point> sites, const PeriodicImages& images,
               const std::stop_token& stop);

    /// Looks at every pair once. The energy never rises; after finitely many sweeps there is nothing left to swap.
    /// @param stop  asked every few sites; ends the sweep
    /// @returns     whether anything was swapped
    bool sweep(const std::stop_token& stop);

    /// Centroid of each site's samples [sites]; on a torus within its box.
    std::span<const Point> centroids() const { return sites_; }

    /// Samples of a site [capacity].
    std::span<const Point> cell(std::size_t site) const { return {&samples_[site * capacity_], capacity_}; }

    double energy() const;

private:
    /// A sample and what its move to the other site gains.
    struct Offer {
        double gain;
        std::uint32_t sample;
    };

    bool deal(std::span<const Point> samples, const std::stop_token& stop);
    bool has_changed_lately(std::uint32_t site) const { return changed_[site] + 1 >= sweeps_; }
    bool swap(std::uint32_t first, std::uint32_t second);
    double find_gains(std::uint32_t from, std::uint32_t to, std::vector<double>& gains) const;
    bool is_clear_of_seams(std::uint32_t from, std::uint32_t to) const;
    void find_offers(std::uint32_t site, const std::vector<double>& gains, double least,
                     std::vector<Offer>& offers) const;
    void settle(std::uint32_t site);

    PeriodicImages images_;
    std::size_t capacity_;
    std::vector<Point> sites_;
    std::vector<Point> samples_;          ///< [sites * capacity]: those of the first site, of the second, ...
    std::vector<double> radii_;           ///< [sites]: distance to the farthest of the site's samples
    std::vector<std::uint32_t> changed_;  ///< [sites]: sweep in which it swapped last
    std::uint32_t sweeps_ = 0;

    // Of the two sites being looked at: squared distance of each sample from its own site less that from the other.
    std::vector<double> first_gains_, second_gains_;
    std::vector<Offer> first_offers_, second_offers_;
};

}  // namespace ccdt
