#include "core/polish/ink_push.h"

#include <algorithm>
#include <cmath>

#include "core/ccdt/border.h"

namespace ccdt {

namespace {

constexpr double kPi = 3.141592653589793;

/// Sites by the cells that they stand in.
class CellList {
public:
    CellList(const Domain& domain, std::span<const InkSite> sites)
        : torus_(domain.is_torus()), sides_(domain.unit_bounds().max) {
        const double side = std::sqrt(sides_.x * sides_.y / static_cast<double>(sites.size()));
        const auto cells = [&](double length) {
            return std::max(1, static_cast<int>(std::min(length / side, static_cast<double>(sites.size()))));
        };
        columns_ = cells(sides_.x);
        rows_ = cells(sides_.y);
        first_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
        sorted_.resize(sites.size());
        for (const InkSite& site : sites) ++first_[cell_of(site.place)];
        std::size_t sum = 0;
        for (std::uint32_t& count : first_) {
            sum += count;
            count = static_cast<std::uint32_t>(sum);
        }
        for (std::size_t i = sites.size(); i-- > 0;) {
            sorted_[--first_[cell_of(sites[i].place)]] = {sites[i].place, sites[i].ink};
        }
    }

    /// Calls with the place and the ink of each site that may be nearer than the reach, its own among them.
    template <class Function>
    void for_near(Point p, double reach, Function&& function) const {
        const Range x = range(p.x, reach, sides_.x, columns_), y = range(p.y, reach, sides_.y, rows_);
        for (int j = y.first; j <= y.last; ++j) {
            for (int i = x.first; i <= x.last; ++i) {
                const int column = wrapped(i, columns_), row = wrapped(j, rows_);
                const int around = (i - column) / columns_, up = (j - row) / rows_;
                const Point shift{around * sides_.x, up * sides_.y};
                const std::size_t cell = index(column, row);
                for (std::uint32_t k = first_[cell]; k < first_[cell + 1]; ++k) {
                    function(sorted_[k].place + shift, sorted_[k].ink);
                }
            }
        }
    }

private:
    struct Listed {
        Point place;
        std::uint32_t ink;
    };

    struct Range {
        int first, last;
    };

    static int wrapped(int i, int cells) { return i < 0 ? i + cells : i >= cells ? i - cells : i; }

    std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    }

    Range range(double v, double reach, double side, int cells) const {
        const double scale = cells / side;
        const auto place = [&](double at) { return static_cast<int>(std::floor(at * scale)); };
        if (!torus_) return {std::clamp(place(v - reach), 0, cells - 1), std::clamp(place(v + reach), 0, cells - 1)};
        const Range wanted{place(v - reach), place(v + reach)};
        const int around = std::min(wanted.last, wanted.first + cells - 1);
        return {std::max(wanted.first, -cells), std::min(around, 2 * cells - 1)};
    }

    std::size_t cell_of(Point p) const {
        const auto place = [](double v, double side, int cells) {
            return std::clamp(static_cast<int>(v / side * cells), 0, cells - 1);
        };
        return index(place(p.x, sides_.x, columns_), place(p.y, sides_.y, rows_));
    }

    bool torus_;
    Point sides_;
    int columns_ = 1, rows_ = 1;
    std::vector<std::uint32_t> first_;  ///< [cells + 1]
    std::vector<Listed> sorted_;        ///< [sites] by cells
};

/// A way for each site that stands where another one does.
Point own_way(std::uint32_t site) {
    constexpr double kGolden = 0.6180339887498949;
    const double angle = 2 * kPi * kGolden * site;
    return {std::cos(angle), std::sin(angle)};
}

}  // namespace

std::vector<Point> push_inks_apart(const Domain& domain, std::span<const InkSite> sites, double reach, double push,
                                   const std::stop_token& stop) {
    constexpr std::uint32_t kStopStride = 4096;
    const CellList cells(domain, sites);
    std::vector<Point> moves(sites.size());
    for (std::uint32_t a = 0; a < sites.size(); ++a) {
        if (a % kStopStride == 0 && stop.stop_requested()) break;
        const InkSite& site = sites[a];
        const double least = reach * hexagonal_spacing(1) * site.spacing;
        cells.for_near(site.place, least, [&](Point other, std::uint32_t ink) {
            if (ink == site.ink) return;
            const Point apart = site.place - other;
            const double squared = dot(apart, apart);
            if (squared >= least * least) return;
            const double distance = std::sqrt(squared);
            const Point way = distance > 1e-9 * least ? 1 / distance * apart : own_way(a);
            moves[a] = moves[a] + push * (least - distance) * way;
        });
    }
    return moves;
}

}  // namespace ccdt
