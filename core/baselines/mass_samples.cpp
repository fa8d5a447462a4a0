// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/mass_samples.h"

#include "core/base/random.h"
#include "core/baselines/bisection.h"

namespace ccdt {

namespace {

class Sampler {
public:
    Sampler(const Bisection& bisection, std::size_t count, std::uint64_t seed, const std::stop_token& stop)
        : bisection_(bisection), random_(seed, kStream), count_(count), stop_(stop) {}

    std::vector<Point> draw(const std::vector<Part>& parts);

private:
    static constexpr std::uint64_t kStream = 0x73616d706c6573;  // differs from the streams of StartSites

    Point draw_in(const Part& part);
    void divide(const Part& part, double begin, double end, int depth);
    void halve(const Part& part, double begin, double end, int depth);

    /// Returns the position of the middle of the next sample's share in the sequence of shares.
    double next_middle() const { return static_cast<double>(samples_.size()) + 0.5; }

    const Bisection& bisection_;
    Random random_;
    std::size_t count_;
    const std::stop_token& stop_;
    double share_ = 1;  ///< mass of one share
    std::vector<Point> samples_;
    bool stopped_ = false;
};

std::vector<Point> Sampler::draw(const std::vector<Part>& parts) {
    double total = 0;
    for (const Part& part : parts) total += part.mass();
    share_ = total / static_cast<double>(count_);
    samples_.reserve(count_);
    double begin = 0;
    for (const Part& part : parts) {
        const double end = begin + part.mass() / share_;
        divide(part, begin, end, 0);
        begin = end;
    }
    return std::move(samples_);
}

Point Sampler::draw_in(const Part& part) {
    double u = random_.uniform(), v = random_.uniform();
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    const auto& [a, b, c] = part.corners;
    return a + u * (b - a) + v * (c - a);
}

/// Draws the samples of a part, recursing into halves if it contains more than one share.
/// @param begin, end  range of the part in the sequence of shares
void Sampler::divide(const Part& part, double begin, double end, int depth) {
    constexpr int kMaxDepth = 100;
    constexpr double kThin = 0.25;  // relative to the part's mean density; a sparser point does not represent the part
    constexpr std::size_t kStopStride = 4096;
    if (stopped_) return;
    while (samples_.size() < count_ && next_middle() < end) {
        if (end - begin > 1 && depth < kMaxDepth) return halve(part, begin, end, depth);
        const Point p = draw_in(part);
        const double area = 0.5 * cross(part.corners[1] - part.corners[0], part.corners[2] - part.corners[0]);
        const bool is_thin = bisection_.at(p) * area < kThin * (end - begin) * share_;
        if (is_thin && depth < kMaxDepth) return halve(part, begin, end, depth);
        samples_.push_back(p);
        if (samples_.size() % kStopStride == 0) stopped_ = stop_.stop_requested();
    }
}

void Sampler::halve(const Part& part, double begin, double end, int depth) {
    const auto [first, second] = bisection_.halves(part);
    // The half nearer to the last sample goes first. Both halves share the midpoint of the divided edge.
    const Point middle = second.corners[0], along = second.corners[1] - first.corners[0];
    const bool swap = !samples_.empty() && dot(samples_.back() - middle, along) > 0;
    const Part& nearer = swap ? second : first;
    const double cut = std::min(end, begin + nearer.mass() / share_);
    divide(nearer, begin, cut, depth + 1);
    divide(swap ? first : second, cut, end, depth + 1);
}

}  // namespace

std::vector<Point> mass_samples(const Domain& domain, const Triangulation& mesh, const Density& density,
                                std::size_t count, std::uint64_t seed, const std::stop_token& stop) {
    const Bisection bisection(domain, density);
    return Sampler(bisection, count, seed, stop).draw(bisection.parts_of(domain, mesh));
}

}  // namespace ccdt
