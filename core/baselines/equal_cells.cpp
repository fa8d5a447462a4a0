// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/equal_cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace ccdt {

namespace {

/// Returns a step that is coprime to `count` and near the golden section. Repeated, it visits all numbers below
/// `count`, and at any time the visited numbers are evenly spread.
std::size_t golden_step(std::size_t count) {
    auto step = static_cast<std::size_t>(0.6180339887498949 * static_cast<double>(count));
    while (std::gcd(step, count) != 1) ++step;
    return step;
}

}  // namespace

EqualCells::EqualCells(std::vector<Point> samples, std::span<const Point> sites, const PeriodicImages& images,
                       const std::stop_token& stop)
    : images_(images), capacity_(samples.size() / sites.size()), radii_(sites.size()), changed_(sites.size(), 0) {
    for (const Point& site : sites) sites_.push_back(images.in_box(site));
    if (!assign_samples(samples, stop)) return;
    for (std::uint32_t i = 0; i < sites_.size(); ++i) update_site(i);
}

/// Assigns each sample to the nearest site with free capacity, in an order spread evenly over the domain.
/// @returns  false after a stop
bool EqualCells::assign_samples(std::span<const Point> samples, const std::stop_token& stop) {
    constexpr std::size_t kStopStride = 16384;
    if (stop.stop_requested()) return false;
    samples_.resize(samples.size());
    std::vector<std::size_t> filled(sites_.size(), 0);
    SiteTree open(sites_, images_);
    const std::size_t step = golden_step(samples.size());
    std::size_t number = 0;
    for (std::size_t i = 0; i < samples.size(); ++i, number = (number + step) % samples.size()) {
        if (i % kStopStride == 0 && stop.stop_requested()) return false;
        const std::uint32_t site = open.nearest(samples[number])->site;
        samples_[site * capacity_ + filled[site]] = samples[number];
        if (++filled[site] == capacity_) open.hide(site);
    }
    return true;
}

bool EqualCells::sweep(const std::stop_token& stop) {
    constexpr std::uint32_t kStopStride = 16;
    const SiteTree tree(sites_, images_);
    std::vector<SiteTree::Found> nearby;
    bool swapped = false;
    ++sweeps_;
    for (std::uint32_t i = 0; i < sites_.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) break;
        // If a sample is nearer to another site, its distance from its own site is more than half the distance between
        // the two sites.
        tree.within(sites_[i], 2 * radii_[i], nearby);
        for (const auto& [j, position] : nearby) {
            if (j == i || (!has_changed_lately(i) && !has_changed_lately(j))) continue;
            const Point way = images_.shortest(sites_[j] - sites_[i]);
            const bool had = j < i && dot(way, way) <= 4 * radii_[j] * radii_[j];
            if (!had) swapped |= swap(i, j);
        }
    }
    return swapped;
}

bool EqualCells::swap(std::uint32_t first, std::uint32_t second) {
    constexpr double kMinGain = 1e-9;  // relative to the squared distance of the sites; less is a rounding error
    const Point way = images_.shortest(sites_[second] - sites_[first]);
    const double squared = dot(way, way), length = std::sqrt(squared);
    const double least = kMinGain * squared;
    // A sample gains at most as much as a sample at the point of its cell's circle that is nearest to the other site.
    // If the largest gains of the two cells add up to less than 0, no swap lowers the energy.
    if (radii_[first] + radii_[second] < length) return false;
    const double most_first = find_gains(first, second, first_gains_);
    if (most_first + length * (2 * radii_[second] - length) < 0) return false;
    const double most_second = find_gains(second, first, second_gains_);
    if (!(most_first + most_second > least)) return false;
    find_offers(first, first_gains_, least - most_second, first_offers_);
    find_offers(second, second_gains_, least - most_first, second_offers_);
    const std::size_t most = std::min(first_offers_.size(), second_offers_.size());
    for (std::size_t i = 0; i < most && first_offers_[i].gain + second_offers_[i].gain > least; ++i) {
        std::swap(samples_[first_offers_[i].sample], samples_[second_offers_[i].sample]);
    }
    update_site(first);
    update_site(second);
    return true;
}

/// Computes the gain of moving each sample of a cell to the other cell.
/// @returns  the largest gain
double EqualCells::find_gains(std::uint32_t from, std::uint32_t to, std::vector<double>& gains) const {
    const Point a = sites_[from], b = sites_[to];
    const auto samples = cell(from);
    gains.resize(samples.size());
    if (is_clear_of_seams(from, to)) {
        const Point way = 2 * (b - a), middle = 0.5 * (a + b);
        for (std::size_t i = 0; i < samples.size(); ++i) gains[i] = dot(samples[i] - middle, way);
    } else {
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Point own = images_.shortest(samples[i] - a), other = images_.shortest(samples[i] - b);
            gains[i] = dot(own, own) - dot(other, other);
        }
    }
    return *std::ranges::max_element(gains);
}

/// Whether the shortest vectors from the first site's samples to both sites are known not to cross a seam.
bool EqualCells::is_clear_of_seams(std::uint32_t from, std::uint32_t to) const {
    if (!images_.is_torus()) return true;
    const Point a = sites_[from], period = images_.period(), way = sites_[to] - a;
    const double radius = radii_[from];
    return a.x >= radius && a.y >= radius && a.x <= period.x - radius && a.y <= period.y - radius &&
           std::abs(way.x) + radius <= period.x / 2 && std::abs(way.y) + radius <= period.y / 2;
}

/// Finds the samples that gain more than `least`, in descending order of gain.
void EqualCells::find_offers(std::uint32_t site, const std::vector<double>& gains, double least,
                             std::vector<Offer>& offers) const {
    offers.clear();
    for (std::size_t i = 0; i < gains.size(); ++i) {
        if (gains[i] > least) offers.push_back({gains[i], static_cast<std::uint32_t>(site * capacity_ + i)});
    }
    std::ranges::sort(offers, [](const Offer& a, const Offer& b) {
        return a.gain != b.gain ? a.gain > b.gain : a.sample < b.sample;
    });
}

void EqualCells::update_site(std::uint32_t site) {
    const Point before = sites_[site];
    Point sum;
    for (const Point& p : cell(site)) sum = sum + images_.shortest(p - before);
    sites_[site] = images_.in_box(before + 1 / static_cast<double>(capacity_) * sum);
    double farthest = 0;
    for (const Point& p : cell(site)) {
        const Point way = images_.shortest(p - sites_[site]);
        farthest = std::max(farthest, dot(way, way));
    }
    radii_[site] = std::sqrt(farthest);
    changed_[site] = sweeps_;
}

double EqualCells::energy() const {
    double sum = 0;
    for (std::size_t i = 0; i < sites_.size(); ++i) {
        for (const Point& p : cell(i)) {
            const Point way = images_.shortest(p - sites_[i]);
            sum += dot(way, way);
        }
    }
    return sum;
}

}  // namespace ccdt
