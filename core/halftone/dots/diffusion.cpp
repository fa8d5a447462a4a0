// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dots/diffusion.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <utility>

namespace ccdt {

namespace {

constexpr std::uint8_t kFull = 255;

/// A pixel that receives part of an error.
struct Neighbour {
    int ahead;     ///< number of columns ahead in the direction of travel
    int rows;      ///< number of rows below
    float weight;  ///< relative share of the error
};
constexpr std::array<Neighbour, 4> kNeighbours = {{{1, 0, 7}, {-1, 1, 3}, {0, 1, 5}, {1, 1, 1}}};

class Diffusion {
public:
    Diffusion(std::vector<std::uint8_t>& shares, int width, int height)
        : shares_(shares), width_(width), height_(height) {
        for (auto& row : errors_) row.resize(static_cast<std::size_t>(width));
    }

    void run() {
        for (int y = 0; y < height_; ++y) {
            const int ahead = y % 2 == 0 ? 1 : -1;
            for (int i = 0; i < width_; ++i) quantize(ahead > 0 ? i : width_ - 1 - i, y, ahead);
            errors_[0].swap(errors_[1]);
            errors_[1].assign(errors_[1].size(), 0);
        }
    }

private:
    std::uint8_t& share(int x, int y) {
        return shares_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
    }

    bool is_open(int x, int y) {
        return x >= 0 && x < width_ && y < height_ && share(x, y) != 0 && share(x, y) != kFull;
    }

    void quantize(int x, int y, int ahead) {
        if (!is_open(x, y)) return;
        std::uint8_t& here = share(x, y);
        const float wanted = here + errors_[0][static_cast<std::size_t>(x)] + std::exchange(carried_, 0.0f);
        here = wanted > kFull / 2.0f ? kFull : 0;
        distribute_error(wanted - here, x, y, ahead);
    }

    void distribute_error(float error, int x, int y, int ahead) {
        float weights = 0;
        for (const auto& [along, rows, weight] : kNeighbours) {
            if (is_open(x + along * ahead, y + rows)) weights += weight;
        }
        if (!(weights > 0)) carried_ += error;
        for (const auto& [along, rows, weight] : kNeighbours) {
            const int to = x + along * ahead;
            if (is_open(to, y + rows))
                errors_[static_cast<std::size_t>(rows)][static_cast<std::size_t>(to)] += weight / weights * error;
        }
    }

    std::vector<std::uint8_t>& shares_;
    int width_;
    int height_;
    std::array<std::vector<float>, 2> errors_;  ///< [width] errors that pixels of this row and of the next row receive
    float carried_ = 0;                         ///< error that no neighbour could take
};

}  // namespace

void diffuse(std::vector<std::uint8_t>& shares, int width, int height) {
    assert(shares.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    Diffusion(shares, width, height).run();
}

}  // namespace ccdt
