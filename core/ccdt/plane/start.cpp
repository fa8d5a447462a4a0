// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/plane/start.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "core/base/random.h"
#include "core/density/coverage.h"
#include "core/density/zones.h"
#include "core/geometry/apportion.h"
#include "core/geometry/morton.h"

namespace ccdt {

namespace {

/// Number of sites drawn in each cell. With one site per cell, the cells are visible: the peak of a draft's spectrum is
/// nearly twice as high (benchmark TorusPattern). With 64 sites per cell, long waves arise (test
/// StartSites.FollowTheDensity).
constexpr std::size_t kSitesPerCell = 4;

/// Number of sites in a cell that the border cuts. With more sites, too many would lie on the wrong side of fjords and
/// straits, which sites cannot cross.
constexpr std::size_t kSitesPerCutCell = 1;

/// Returns the position in [x0, x1] at which an increasing function has completed a given share of its rise over this
/// interval. The function is linear between successive whole numbers.
template <class Function>
double invert(double x0, double x1, double share, Function&& function) {
    double f0 = function(x0), f1 = function(x1);
    const double level = std::lerp(f0, f1, share);
    auto below = static_cast<long>(std::floor(x0)) + 1;
    auto above = static_cast<long>(std::ceil(x1)) - 1;
    while (below <= above) {
        const long middle = (below + above) / 2;
        const auto x = static_cast<double>(middle);
        const double f = function(x);
        if (f <= level) {
            x0 = x;
            f0 = f;
            below = middle + 1;
        } else {
            x1 = x;
            f1 = f;
            above = middle - 1;
        }
    }
    if (!(f1 > f0)) return (x0 + x1) / 2;
    return std::clamp(x0 + (x1 - x0) * (level - f0) / (f1 - f0), x0, x1);
}

/// Returns the share of each grid cell that the domain covers [rows * columns].
std::vector<double> shares_of(const Domain& domain, int columns, int rows) {
    std::vector<BorderEdge> border;
    border.reserve(domain.corner_count());
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) border.push_back({ring[i], ring[(i + 1) % ring.size()]});
    }
    auto shares = coverage(border, domain.unit_bounds().max, columns, rows);
    for (double& share : shares) share = std::clamp(share, 0.0, 1.0);
    return shares;
}

/// Returns the number of the pixel at a coordinate of the grid.
int pixel_at(double v, int cells, int pixels) {
    return std::min(static_cast<int>(v / cells * pixels), pixels - 1);
}

/// Integrals over a zone of the density.
struct Zone {
    double capacity = 0;
    double squared = 0;  ///< integral of the squared density
    Point3 moment;       ///< integral of the density times the position
    double density() const { return capacity > 0 ? squared / capacity : 0; }
};

/// Divides sites among zones in proportion to their capacities. All zones of about the same density together, and among
/// them those in any region, get their share within about one site.
/// @returns  [zones]
std::vector<std::size_t> divide_among(std::span<const Zone> zones, std::size_t sites) {
    std::vector<double> densities(zones.size());
    std::ranges::transform(zones, densities.begin(), &Zone::density);
    const auto classes = group_into_classes(densities);
    std::vector<std::vector<double>> quotas(classes.size(), std::vector<double>(zones.size()));
    std::vector<double> sums(classes.size());
    std::vector<Point3> positions(zones.size()), line;  // of the zones; of the classes
    double total = 0;
    for (std::size_t each = 0; each < classes.size(); ++each) {
        line.push_back({static_cast<double>(each), 0, 0});
        for (const std::uint32_t number : classes[each]) {
            const Zone& zone = zones[number];
            if (zone.capacity > 0) positions[number] = 1 / zone.capacity * zone.moment;
            quotas[each][number] = zone.capacity;
            sums[each] += zone.capacity;
            total += zone.capacity;
        }
    }
    std::vector<double> shares = sums;
    for (double& share : shares) share *= static_cast<double>(sites) / total;
    const auto counts = apportion(line, {&shares, 1}).front();
    for (std::size_t each = 0; each < sums.size(); ++each) {
        for (double& quota : quotas[each]) quota *= sums[each] > 0 ? static_cast<double>(counts[each]) / sums[each] : 0;
    }
    std::vector<std::size_t> result(zones.size());
    for (const auto& numbers : apportion(positions, quotas))
        std::ranges::transform(result, numbers, result.begin(), std::plus{});
    return result;
}

}  // namespace

StartSites::StartSites(const Domain& domain, const Density& density, const Options& options, const Support* support)
    : density_(density),
      support_(support != nullptr && support->zones() > 1 ? support : nullptr),
      seed_(options.seed),
      fixed_(to_unit_frame(domain, options.fixed)) {
    unit_size_ = domain.unit_bounds().max;
    knows_cuts_ = !domain.is_box() && density.is_uniform() && fixed_.empty();
    constexpr double kMaxCells = 4194304;
    if (!density.is_uniform()) {
        // A very fine picture is divided into blocks of pixels, which become the cells of the grid.
        const double pixels = static_cast<double>(density.width()) * density.height();
        const int block = pixels > kMaxCells ? static_cast<int>(std::ceil(std::sqrt(pixels / kMaxCells))) : 1;
        columns_ = (density.width() + block - 1) / block;
        rows_ = (density.height() + block - 1) / block;
    }
    if (!domain.is_box() || !fixed_.empty()) {
        const double share = domain.unit_area() / (unit_size_.x * unit_size_.y);
        const double for_each = fixed_.empty() ? 4 : 16;  // cells per site; areas of fixed points have finer detail
        const auto all = static_cast<double>(options.sites + fixed_.size());
        const double cells = std::clamp(for_each * all / share, 4096.0, kMaxCells);
        const double side = std::sqrt(unit_size_.x * unit_size_.y / cells);
        const auto refine = [&](int& own, int other, double length) {
            const auto most = static_cast<int>(4 * kMaxCells / other);
            const int fine = std::max(own, std::min(std::clamp(static_cast<int>(length / side), 1, 4096), most));
            own = support_ != nullptr ? fine / own * own : fine;  // no cell may belong to two zones
        };
        refine(columns_, rows_, unit_size_.x);
        refine(rows_, columns_, unit_size_.y);
    }
    make_grid(domain, options.sites);
    const Rectangle box{0, static_cast<double>(columns_), 0, static_cast<double>(rows_)};
    if (options.start == Start::Random) {
        cells_.push_back(box);
        cell_of_.assign(options.sites, 0);
        number_along_curve();
    } else {
        cells_.reserve(options.sites / 2 + 1);
        cell_of_.reserve(options.sites);
        divide(box, options.sites);
        if (support_ != nullptr) share_out_zones();
    }
}

void StartSites::make_grid(const Domain& domain, std::size_t sites) {
    const auto width = static_cast<std::size_t>(columns_);
    const auto height = static_cast<std::size_t>(rows_);
    std::vector<double> share;
    if (!domain.is_box()) share = shares_of(domain, columns_, rows_);
    std::vector<double> masses;
    if (!fixed_.empty()) masses = masses_remaining(domain, share, sites);
    sums_.assign((width + 1) * (height + 1), 0);
    std::vector<double> row_mass(width, 1);
    for (std::size_t row = 0; row < height; ++row) {
        if (!density_.is_uniform())
            density_.resample_row(density_.cells(), columns_, rows_, static_cast<int>(row), row_mass);
        double from_left = 0;
        for (std::size_t column = 0; column < width; ++column) {
            const std::size_t cell = row * width + column;
            from_left += masses.empty() ? row_mass[column] * (share.empty() ? 1 : share[cell]) : masses[cell];
            sums_[(row + 1) * (width + 1) + column + 1] = sums_[row * (width + 1) + column + 1] + from_left;
        }
    }
}

/// Returns the capacities of the cells minus the capacities that fixed points take there.
/// @param share  share of each cell that the domain covers; empty: 1 for every cell
std::vector<double> StartSites::masses_remaining(const Domain& domain, const std::vector<double>& share,
                                                 std::size_t sites) {
    const auto width = static_cast<std::size_t>(columns_), height = static_cast<std::size_t>(rows_);
    std::vector<double> masses(width * height, 1);
    for (std::size_t row = 0; row < height && !density_.is_uniform(); ++row)
        density_.resample_row(density_.cells(), columns_, rows_, static_cast<int>(row),
                              std::span(masses).subspan(row * width, width));
    for (std::size_t cell = 0; cell < share.size(); ++cell) masses[cell] *= share[cell];
    fixed_area_ = subtract_fixed_area(domain, fixed_, sites, columns_, rows_, masses);
    return masses;
}

double StartSites::sum(double x, double y) const {
    const int i = std::min(static_cast<int>(x), columns_ - 1);
    const int j = std::min(static_cast<int>(y), rows_ - 1);
    const double* s =
        &sums_[static_cast<std::size_t>(j) * (static_cast<std::size_t>(columns_) + 1) + static_cast<std::size_t>(i)];
    const double* above = s + columns_ + 1;
    const double fx = x - i, fy = y - j;
    return (1 - fy) * (s[0] + fx * (s[1] - s[0])) + fy * (above[0] + fx * (above[1] - above[0]));
}

/// Returns the abscissa of a vertical cut that has a given share of the box's capacity on its left.
double StartSites::cut_across_x(const Rectangle& box, double share) const {
    if (box.x1 - box.x0 <= 1 && std::ceil(box.x1) - std::floor(box.x0) <= 1) return std::lerp(box.x0, box.x1, share);
    return invert(box.x0, box.x1, share, [&](double x) { return sum(x, box.y1) - sum(x, box.y0); });
}

double StartSites::cut_across_y(const Rectangle& box, double share) const {
    if (box.y1 - box.y0 <= 1 && std::ceil(box.y1) - std::floor(box.y0) <= 1) return std::lerp(box.y0, box.y1, share);
    return invert(box.y0, box.y1, share, [&](double y) { return sum(box.x1, y) - sum(box.x0, y); });
}

void StartSites::divide(const Rectangle& box, std::size_t sites) {
    if (sites <= (is_cut(box) ? kSitesPerCutCell : kSitesPerCell)) {
        cell_of_.insert(cell_of_.end(), sites, static_cast<std::uint32_t>(cells_.size()));
        cells_.push_back(box);
        return;
    }
    const std::size_t first = sites / 2;
    const double share = static_cast<double>(first) / static_cast<double>(sites);
    const bool wide = (box.x1 - box.x0) * unit_size_.x * rows_ >= (box.y1 - box.y0) * unit_size_.y * columns_;
    if (wide) {
        const double x = cut_across_x(box, share);
        divide({box.x0, x, box.y0, box.y1}, first);
        divide({x, box.x1, box.y0, box.y1}, sites - first);
    } else {
        const double y = cut_across_y(box, share);
        divide({box.x0, box.x1, box.y0, y}, first);
        divide({box.x0, box.x1, y, box.y1}, sites - first);
    }
}

/// Calls visit(part, capacity, zone) for the part of a box in each cell of the grid.
template <class Visit>
void StartSites::for_parts(const Rectangle& box, Visit&& visit) const {
    for (int row = static_cast<int>(box.y0); row < box.y1; ++row) {
        const double* const low = &sums_[static_cast<std::size_t>(row) * (static_cast<std::size_t>(columns_) + 1)];
        const double* const high = low + columns_ + 1;
        for (int column = static_cast<int>(box.x0); column < box.x1; ++column) {
            const Rectangle part{std::max(box.x0, 1.0 * column), std::min(box.x1, column + 1.0),
                                 std::max(box.y0, 1.0 * row), std::min(box.y1, row + 1.0)};
            const double cell = high[column + 1] - high[column] - low[column + 1] + low[column];
            const double capacity = std::max(0.0, cell) * (part.x1 - part.x0) * (part.y1 - part.y0);
            visit(part, capacity, support_->zone(to_unit(column + 0.5, row + 0.5)));
        }
    }
}

/// Assigns cells and zones to the sites again, so that each zone gets its share. Does nothing without any capacity.
void StartSites::share_out_zones() {
    struct Share {
        std::uint32_t cell;
        double capacity;
    };
    std::vector<std::vector<Share>> shares(support_->zones());
    std::vector<Zone> zones(shares.size());
    for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
        for_parts(cells_[cell], [&](const Rectangle& part, double capacity, std::uint32_t number) {
            if (!(capacity > 0)) return;
            auto& own = shares[number];
            if (own.empty() || own.back().cell != cell) own.push_back({cell, 0});
            own.back().capacity += capacity;
            const double x = (part.x0 + part.x1) / 2, y = (part.y0 + part.y1) / 2;
            const Point middle = to_unit(x, y);
            Zone& zone = zones[number];
            zone.capacity += capacity;
            zone.squared += capacity * density_at(x, y);
            zone.moment = zone.moment + capacity * Point3{middle.x, middle.y, 0};
        });
    }
    if (std::ranges::all_of(shares, &std::vector<Share>::empty)) return;
    const auto counts = divide_among(zones, cell_of_.size());
    std::vector<std::pair<std::uint32_t, ZoneShare>> drawn;  // cells and zones of the sites
    for (std::uint32_t zone = 0; zone < counts.size(); ++zone) {
        const double step = zones[zone].capacity / static_cast<double>(counts[zone]);
        double done = 0;
        std::size_t count = 0;
        for (const Share& share : shares[zone]) {
            done += share.capacity;
            for (; count < counts[zone] && done > (static_cast<double>(count) + 0.5) * step; ++count)
                drawn.push_back({share.cell, {zone, share.capacity}});
        }
    }
    std::ranges::stable_sort(drawn, {}, [](const auto& site) { return site.first; });
    assert(drawn.size() == cell_of_.size());
    cell_of_.clear();
    for (const auto& [cell, zone] : drawn) {
        cell_of_.push_back(cell);
        zone_of_.push_back(zone);
    }
}

/// Whether a considerable part of a cell lies outside the domain.
bool StartSites::is_cut(const Rectangle& box) const {
    constexpr double kCut = 0.95;  // relative to the capacity of a cell that lies inside
    if (!knows_cuts_) return false;
    const double inside = sum(box.x1, box.y1) - sum(box.x0, box.y1) - sum(box.x1, box.y0) + sum(box.x0, box.y0);
    return inside < kCut * (box.x1 - box.x0) * (box.y1 - box.y0);
}

double StartSites::density_at(double x, double y) const {
    return density_.value(pixel_at(x, columns_, density_.width()), pixel_at(y, rows_, density_.height()));
}

/// Returns the density at a position relative to the largest density in its grid cell. If the density is no finer than
/// the grid, returns 1 where the density is positive, else 0.
double StartSites::acceptance(double x, double y) const {
    if (density_.is_uniform()) return 1;
    const double value = density_at(x, y);
    if (columns_ >= density_.width() && rows_ >= density_.height()) return value > 0 ? 1 : 0;
    const double column = std::floor(x), row = std::floor(y);
    const int last_i = pixel_at(std::nextafter(column + 1, 0.0), columns_, density_.width());
    const int last_j = pixel_at(std::nextafter(row + 1, 0.0), rows_, density_.height());
    double largest = value;
    for (int j = pixel_at(row, rows_, density_.height()); j <= last_j; ++j) {
        for (int i = pixel_at(column, columns_, density_.width()); i <= last_i; ++i) {
            largest = std::max(largest, density_.value(i, j));
        }
    }
    return largest > 0 ? value / largest : 0;
}

/// Numbers independently drawn sites along Morton's curve.
void StartSites::number_along_curve() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> positions;
    positions.reserve(cell_of_.size());
    for (std::uint32_t i = 0; i < cell_of_.size(); ++i) {
        positions.emplace_back(morton_position(draw_stream(i, 0, cells_[0])), i);
    }
    std::sort(positions.begin(), positions.end());
    for (const auto& [position, number] : positions) stream_of_.push_back(number);
}

Point StartSites::draw(std::size_t site, int attempt) const {
    if (!zone_of_.empty()) return draw_in_zone(site, attempt);
    return draw_stream(stream_of_.empty() ? site : stream_of_[site], attempt, cells_[cell_of_[site]]);
}

Point StartSites::draw_stream(std::uint64_t stream, int attempt, const Rectangle& box) const {
    // At least one try in n is accepted, where n is the number of pixels per cell: 16 for 64 megapixels. In that case
    // all tries fail for one site in 10^7, which is then placed anywhere in its cell.
    constexpr int kTries = 256;
    Random random(seed_, stream + (static_cast<std::uint64_t>(attempt) << 40));
    double x = 0, y = 0;
    for (int i = 0; i < kTries; ++i) {
        x = cut_across_x(box, random.uniform());
        // Within one column of the grid, the density depends on y alone.
        const double column = std::min(std::floor(x), columns_ - 1.0);
        const Rectangle strip{std::max(box.x0, column), std::min(box.x1, column + 1), box.y0, box.y1};
        y = cut_across_y(strip, random.uniform());
        if (random.uniform() < acceptance(x, y)) break;
    }
    return to_unit(x, y);
}

/// Draws a position in the part of a cell that belongs to the zone of a site.
Point StartSites::draw_in_zone(std::size_t site, int attempt) const {
    const Rectangle& box = cells_[cell_of_[site]];
    const ZoneShare& own = zone_of_[site];
    Random random(seed_, site + (static_cast<std::uint64_t>(attempt) << 40));
    double remaining = random.uniform() * own.capacity;
    Rectangle drawn = box;
    for_parts(box, [&](const Rectangle& part, double capacity, std::uint32_t zone) {
        if (zone != own.zone || remaining < 0 || !(capacity > 0)) return;
        drawn = part;
        remaining -= capacity;
    });
    const double x = std::lerp(drawn.x0, drawn.x1, random.uniform());
    return to_unit(x, std::lerp(drawn.y0, drawn.y1, random.uniform()));
}

}  // namespace ccdt
