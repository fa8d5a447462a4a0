#include "core/halftone/dots.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace ccdt {

namespace {

constexpr double kPi = 3.141592653589793;

/// Squared distance from each pixel's centre to the nearest dot's, where that is within a reach.
class DistanceMap {
public:
    DistanceMap(std::span<const Point> dots, const Canvas& canvas, double reach, const std::stop_token& stop)
        : squared_(static_cast<std::size_t>(canvas.width) * static_cast<std::size_t>(canvas.height),
                   std::numeric_limits<float>::infinity()) {
        for (const Point& dot : dots) {
            if (stop.stop_requested()) return;
            add(canvas.scale * dot, canvas, reach);
        }
    }

    const std::vector<float>& squared() const { return squared_; }

    /// The k-th smallest squared distance, k from 1; infinite beyond the reach.
    float smallest(std::size_t k) const {
        // Positive floats sort like their bits: find the upper half of the bits, then the lower.
        const std::uint32_t upper = select(k, [](std::uint32_t bits) { return bits >> 16; });
        const std::uint32_t lower =
            select(k, [&](std::uint32_t bits) { return bits >> 16 == upper ? bits & 0xffff : kOther; });
        return std::bit_cast<float>(upper << 16 | lower);
    }

private:
    static constexpr std::uint32_t kOther = ~std::uint32_t{0};

    void add(Point centre, const Canvas& canvas, double reach) {
        const auto clip = [](double v, int size) {
            return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
        };
        const int y0 = clip(std::floor(centre.y - reach), canvas.height);
        const int y1 = clip(std::ceil(centre.y + reach), canvas.height);
        for (int y = y0; y < y1; ++y) {
            const double dy = y + 0.5 - centre.y;
            const double half = std::sqrt(std::max(0.0, reach * reach - dy * dy));
            const int x0 = clip(std::floor(centre.x - half), canvas.width);
            const int x1 = clip(std::ceil(centre.x + half), canvas.width);
            float* row = &squared_[static_cast<std::size_t>(y) * static_cast<std::size_t>(canvas.width)];
            const auto dy2 = static_cast<float>(dy * dy);
            const auto first = static_cast<float>(x0 + 0.5 - centre.x);
            for (int x = x0; x < x1; ++x) {
                const float dx = first + static_cast<float>(x - x0);
                row[x] = std::min(row[x], dx * dx + dy2);
            }
        }
    }

    /// The key of rank k, counted from 1, among those that are not kOther; k becomes the rank among equal keys.
    template <class Key>
    std::uint32_t select(std::size_t& k, Key&& key) const {
        std::vector<std::size_t> count(1 << 16, 0);
        for (const float value : squared_) {
            const std::uint32_t bucket = key(std::bit_cast<std::uint32_t>(value));
            if (bucket != kOther) ++count[bucket];
        }
        std::uint32_t bucket = 0;
        for (; count[bucket] < k; ++bucket) k -= count[bucket];
        return bucket;
    }

    std::vector<float> squared_;
};

/// Share of a pixel that a disc covers whose rim passes its centre at this distance, inside being positive.
double pixel_coverage(double inside) {
    return std::clamp(inside + 0.5, 0.0, 1.0);
}

/// The radius at which antialiased dots have the mean coverage; -0.5 if none has.
double antialiased_radius(const std::vector<float>& squared, double mean_coverage, double reach) {
    constexpr std::size_t kBins = 1 << 16;
    std::vector<std::size_t> count(kBins, 0);
    for (const float value : squared) {
        const double bin = std::sqrt(static_cast<double>(value)) / reach * kBins;
        if (bin < kBins) ++count[static_cast<std::size_t>(bin)];
    }
    const double wanted = mean_coverage * static_cast<double>(squared.size());
    double low = -0.5, high = reach;
    for (int i = 0; i < 48; ++i) {
        const double radius = (low + high) / 2;
        double covered = 0;
        for (std::size_t bin = 0; bin < kBins; ++bin) {
            const double distance = (static_cast<double>(bin) + 0.5) * reach / kBins;
            if (distance > radius + 0.5) break;
            covered += static_cast<double>(count[bin]) * pixel_coverage(radius - distance);
        }
        (covered < wanted ? low : high) = radius;
    }
    return (low + high) / 2;
}

struct Fitted {
    DistanceMap map;
    double radius;
};

/// Finds the radius for the mean coverage, looking further out until the reach is enough.
Fitted fit_radius(std::span<const Point> dots, const Canvas& canvas, const DotOptions& options,
                  const std::stop_token& stop) {
    const double pixels = static_cast<double>(canvas.width) * canvas.height;
    const double mean_coverage = std::clamp(options.mean_coverage, 0.0, 1.0);
    const auto wanted = static_cast<std::size_t>(std::lround(mean_coverage * pixels));
    const double alone = std::sqrt(mean_coverage * pixels / (kPi * static_cast<double>(dots.size())));
    const double furthest = std::hypot(canvas.width, canvas.height) + 1;
    for (double reach = std::min(1.4 * alone + 2, furthest);; reach = std::min(1.6 * reach, furthest)) {
        DistanceMap map(dots, canvas, reach, stop);
        const float squared = map.smallest(std::max(wanted, std::size_t{1}));
        const double margin = options.antialias ? 1 : 0;
        if (reach < furthest && !stop.stop_requested() && !(std::sqrt(static_cast<double>(squared)) + margin < reach))
            continue;
        const double radius = options.antialias ? antialiased_radius(map.squared(), mean_coverage, reach)
                              : wanted == 0     ? -1
                                                : std::min(std::sqrt(static_cast<double>(squared)), reach);
        return {std::move(map), radius};
    }
}

}  // namespace

Raster draw_dots(std::span<const Point> dots, const Canvas& canvas, const DotOptions& options,
                 const std::stop_token& stop) {
    assert(canvas.width >= 1 && canvas.height >= 1 && canvas.scale > 0);
    assert(!options.radius || (*options.radius >= 0 && std::isfinite(*options.radius)));
    if (dots.empty()) {
        return {canvas.width, canvas.height, 0,
                std::vector<std::uint8_t>(static_cast<std::size_t>(canvas.width) *
                                          static_cast<std::size_t>(canvas.height))};
    }
    const Fitted fitted = options.radius ? Fitted{DistanceMap(dots, canvas, *options.radius + 1, stop), *options.radius}
                                         : fit_radius(dots, canvas, options, stop);
    Raster raster{canvas.width, canvas.height, std::max(0.0, fitted.radius), {}};
    const std::vector<float>& squared = fitted.map.squared();
    raster.coverage.resize(squared.size());
    if (options.antialias) {
        std::transform(squared.begin(), squared.end(), raster.coverage.begin(), [&](float value) {
            const double share = pixel_coverage(fitted.radius - std::sqrt(static_cast<double>(value)));
            return static_cast<std::uint8_t>(std::lrint(255 * share));
        });
    } else {
        const auto limit = fitted.radius < 0 ? -1.0f : static_cast<float>(fitted.radius * fitted.radius);
        std::transform(squared.begin(), squared.end(), raster.coverage.begin(),
                       [&](float value) { return static_cast<std::uint8_t>(value <= limit ? 255 : 0); });
    }
    return raster;
}

}  // namespace ccdt
