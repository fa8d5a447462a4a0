// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/spot_search.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <utility>

#include "core/dither/error_diffusion.h"
#include "core/dither/tile_sweep.h"
#include "core/dither/visual_error.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

/// An exchange of a pixel with a neighbour may change the print in kSide x kSide squares around the pixel.
constexpr int kReach = 2, kSide = 2 * kReach + 1;
constexpr std::size_t kSquares = index(kSide * kSide);

/// A square near a pixel.
struct Square {
    int column = 0, row = 0;               ///< relative to the pixel, from -kReach to kReach
    PrintedSpot::Neighbourhood changed{};  ///< changed pixels in the neighbourhood of the square

    std::size_t number() const { return index((row + kReach) * kSide + column + kReach); }
};

/// The squares that a change of a pixel, or of a pixel and one of its neighbours, may affect.
class Effect {
public:
    /// @param dx, dy  the neighbour that also changes; both 0: none
    constexpr Effect(int dx, int dy) {
        for (int row = -kReach; row <= kReach; ++row) {
            for (int column = -kReach; column <= kReach; ++column) {
                const PrintedSpot::Neighbourhood changed = bit_of(column, row, 0, 0) | bit_of(column, row, dx, dy);
                if (changed != 0) squares_[count_++] = {column, row, changed};
            }
        }
    }

    std::span<const Square> squares() const { return {squares_.data(), count_}; }

private:
    /// Returns the bit of a pixel in the neighbourhood of a square, or 0 if the pixel is not in it.
    static constexpr PrintedSpot::Neighbourhood bit_of(int column, int row, int x, int y) {
        const bool is_near = std::max(x - column, column - x) <= 1 && std::max(y - row, row - y) <= 1;
        return is_near ? PrintedSpot::bit(x - column, y - row) : PrintedSpot::Neighbourhood{0};
    }

    std::array<Square, kSquares> squares_{};
    std::size_t count_ = 0;
};

/// [3 * (dy + 1) + dx + 1]
constexpr std::array<Effect, 9> kEffects = {
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {0, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

std::span<const Square> squares_of_change(int dx, int dy) {
    return kEffects[index(3 * (dy + 1) + dx + 1)].squares();
}

/// Dark pixels of a picture, and the print that they make.
class PrintedPicture {
public:
    PrintedPicture(int width, int height, const PrintedSpot& spot)
        : spot_(&spot),
          stride_(index(width) + 2 * kReach),
          dark_(stride_ * (index(height) + 2 * kReach), PrintedSpot::kOutside) {
        for (int y = 0; y < height; ++y) std::fill_n(at(0, y), width, PrintedSpot::Neighbourhood{0});
    }

    bool is_dark(int x, int y) const { return (*at(x, y) & PrintedSpot::bit(0, 0)) != 0; }

    /// Returns the covered share of a square.
    float share(int x, int y) const { return spot_->share(*at(x, y)); }

    /// Returns how much more of a square near (x, y) a change would cover; 0 for a square outside the picture.
    float change(int x, int y, const Square& square) const {
        const PrintedSpot::Neighbourhood dark = *at(x + square.column, y + square.row);
        return spot_->share(dark ^ square.changed) - spot_->share(dark);
    }

    void toggle(int x, int y) {
        for (const Square& square : squares_of_change(0, 0)) *at(x + square.column, y + square.row) ^= square.changed;
    }

private:
    PrintedSpot::Neighbourhood* at(int x, int y) { return &dark_[index(y + kReach) * stride_ + index(x + kReach)]; }
    const PrintedSpot::Neighbourhood* at(int x, int y) const { return const_cast<PrintedPicture*>(this)->at(x, y); }

    const PrintedSpot* spot_;
    std::size_t stride_;
    std::vector<PrintedSpot::Neighbourhood> dark_;  ///< with a margin of kReach squares
};

/// Searches changes of a printed picture.
class SpotSearch {
public:
    using Colour = VisualError<1>::Colour;

    /// @param print  picture with which the search begins
    SpotSearch(double blur, std::span<const float> wanted, std::span<const std::uint8_t> given, PrintedPicture print,
               int width, int height, Executor& executor)
        : given_(given),
          print_(std::move(print)),
          width_(width),
          height_(height),
          error_(residual(wanted, print_, width, executor), width, height, blur, executor) {}

    /// Makes the change of a pixel that reduces the visible error most, if any change reduces it.
    /// @returns  whether the picture has changed
    bool visit(int x, int y) {
        static_assert(TileSweep::kTile >= 2 * (VisualError<1>::kReachInPixels + kReach));
        if (given_[pixel(x, y)] != kAnyColour) return false;
        const bool is_dark = print_.is_dark(x, y);
        const Gradients gradients = gradients_around(x, y);
        Change best;
        for (int dy = -std::min(y, 1); dy <= std::min(height_ - 1 - y, 1); ++dy) {
            for (int dx = -std::min(x, 1); dx <= std::min(width_ - 1 - x, 1); ++dx) {
                const bool is_exchange = dx != 0 || dy != 0;
                // Exchanges are considered at the dark pixel only.
                if (is_exchange &&
                    (!is_dark || print_.is_dark(x + dx, y + dy) || given_[pixel(x + dx, y + dy)] != kAnyColour))
                    continue;
                const float error = error_of(x, y, squares_of_change(dx, dy), gradients, best.error);
                if (error < best.error) best = {error, true, dx, dy};
            }
        }
        if (best.is_found) apply(x, y, best);
        return best.is_found;
    }

    PrintedPicture take_result() { return std::move(print_); }

private:
    /// [Square::number()] gradients of the visible error.
    using Gradients = std::array<float, kSquares>;

    /// A change of a pixel, or an exchange with a neighbour.
    struct Change {
        float error = -1e-7f;  ///< change of the visible error; this much is less than rounding errors
        bool is_found = false;
        int dx = 0, dy = 0;  ///< neighbour to exchange with; both 0: none
    };

    static std::vector<Colour> residual(std::span<const float> wanted, const PrintedPicture& print, int width,
                                        Executor& executor) {
        std::vector<Colour> result(wanted.size());
        for_pixels(executor, wanted.size(), [&](std::size_t i) {
            const auto x = static_cast<int>(i % index(width)), y = static_cast<int>(i / index(width));
            result[i] = {print.share(x, y) - wanted[i]};
        });
        return result;
    }

    std::size_t pixel(int x, int y) const { return index(y) * index(width_) + index(x); }

    Gradients gradients_around(int x, int y) const {
        Gradients gradients{};
        std::size_t number = 0;
        for (int row = -kReach; row <= kReach; ++row) {
            for (int column = -kReach; column <= kReach; ++column)
                gradients[number++] = error_.gradient(x + column, y + row)[0];
        }
        return gradients;
    }

    /// Returns by how much a change of the pixel (x, y), with one of its neighbours or without, changes the visible
    /// error.
    /// @param limit  if the change is at least `limit`, the result may be any number that is at least `limit`
    float error_of(int x, int y, std::span<const Square> squares, const Gradients& gradients, float limit) const {
        std::array<const Square*, kSquares> changed{};
        std::array<float, kSquares> by{};
        std::size_t count = 0;
        float linear = 0;
        for (const Square& square : squares) {
            const float change = print_.change(x, y, square);
            if (change == 0) continue;
            linear += change * gradients[square.number()];
            changed[count] = &square;
            by[count++] = change;
        }
        if (2 * linear >= limit) return 2 * linear;  // what follows is not negative
        float products = 0, squares_sum = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const auto& [column, row, bits] = *changed[i];
            float sum = 0;
            for (std::size_t j = 0; j < i; ++j) {
                sum += by[j] * error_.mutual(x + column, y + row, changed[j]->column - column, changed[j]->row - row);
            }
            products += by[i] * sum;
            squares_sum += by[i] * by[i];
        }
        return 2 * (linear + products) + squares_sum * error_.self();
    }

    void apply(int x, int y, const Change& change) {
        for (const Square& square : squares_of_change(change.dx, change.dy)) {
            if (const float by = print_.change(x, y, square); by != 0)
                error_.change(x + square.column, y + square.row, {by});
        }
        print_.toggle(x, y);
        if (change.dx != 0 || change.dy != 0) print_.toggle(x + change.dx, y + change.dy);
    }

    std::span<const std::uint8_t> given_;
    PrintedPicture print_;
    int width_, height_;
    VisualError<1> error_;
};

/// Chooses dark pixels by error diffusion.
PrintedPicture diffused(std::span<const float> wanted, std::span<const std::uint8_t> given, int width, int height,
                        const PrintedSpot& spot) {
    PrintedPicture print(width, height, spot);
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (given[i] == 1) print.toggle(static_cast<int>(i % index(width)), static_cast<int>(i / index(width)));
    }
    using Colour = VisualError<1>::Colour;
    diffuse<Colour>(
        given, width, height, [&](std::size_t i) { return Colour{wanted[i]}; },
        [&](std::size_t i, const Colour& value) {
            const auto x = static_cast<int>(i % index(width)), y = static_cast<int>(i / index(width));
            float added = 0;
            for (const Square& square : squares_of_change(0, 0)) added += print.change(x, y, square);
            if (value[0] < added / 2) return Colour{0};
            print.toggle(x, y);
            return Colour{added};
        });
    return print;
}

}  // namespace

std::vector<std::uint8_t> search_spots(std::span<const float> wanted, std::span<const std::uint8_t> given, int width,
                                       int height, const PrintedSpot& spot, const std::stop_token& stop,
                                       Executor& executor) {
    assert(wanted.size() == index(width) * index(height) && given.size() == wanted.size());
    PrintedPicture print = diffused(wanted, given, width, height, spot);
    for (const double blur : kGreyBlurs) {
        SpotSearch search(blur, wanted, given, std::move(print), width, height, executor);
        TileSweep(width, height).run([&](int x, int y) { return search.visit(x, y); }, stop, executor);
        print = search.take_result();
    }
    std::vector<std::uint8_t> dark(wanted.size());
    for (std::size_t i = 0; i < dark.size(); ++i)
        dark[i] = print.is_dark(static_cast<int>(i % index(width)), static_cast<int>(i / index(width))) ? 1 : 0;
    return dark;
}

}  // namespace ccdt
