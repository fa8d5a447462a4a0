// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>

#include "core/base/executor.h"

namespace ccdt {

/// Returns the smallest even product of powers of 2, 3 and 5 that is >= `least`: a grid size with a fast transform.
/// @param least  at most 1e9
int good_size(double least);

/// Fourier transform of a real grid in the plane or in space, and its inverse.
///
/// The same input gives the same bits in every run, on every processor of one architecture and with any executor. Only
/// one thread at a time may use an object. Throws std::bad_alloc. O(n log n) for n cells, 16 bytes per cell.
class RealTransform {
public:
    /// @param cells     columns, rows and layers, each >= 1; see good_size(). A grid in space consists of a grid of
    ///                  columns * rows cells for each layer. The sums below then also run over the layers, and their
    ///                  exponents have a third term.
    /// @param executor  runs the transforms; must outlive this
    /// @param spare     least size of spare(), as a count of numbers
    ///
    /// All cells are 0 at first.
    explicit RealTransform(const std::array<int, 3>& cells, Executor& executor = inline_executor(),
                           std::size_t spare = 0);
    RealTransform(RealTransform&&) noexcept;
    RealTransform& operator=(RealTransform&&) noexcept;
    ~RealTransform();

    /// Releases the memory. The next call must be grid() or spare(), which allocates the memory again, with all cells
    /// 0.
    void release_memory();

    /// Returns the cells of the grid [layers * rows * columns], row by row.
    std::span<double> grid();

    /// Returns the coefficients [layers * rows * (columns / 2 + 1)], row by row: frequency (x, y) is in column x of row
    /// y mod rows and, in space, frequency (x, y, z) is there in layer z mod layers. The columns of negative x are not
    /// stored: coefficient (x, y) is the complex conjugate of coefficient (-x, -y).
    std::span<std::complex<double>> spectrum();
    std::span<const std::complex<double>> spectrum() const;

    /// Returns the memory of the spectrum as an array of as many real numbers as the constructor's `spare`. It is free
    /// for other use between backward() and forward().
    std::span<double> spare();

    /// Computes spectrum[k] = sum over cells j of grid[j] e^(-2 pi i k.j), k.j = x_k x_j / columns + y_k y_j / rows.
    /// Does not change the grid.
    void forward();

    /// Computes grid[j] = sum over all frequencies k of spectrum[k] e^(2 pi i k.j). So forward() followed by backward()
    /// multiplies by columns * rows. Overwrites the spectrum.
    void backward();

private:
    struct Grids;
    std::unique_ptr<Grids> grids_;
};

/// Cosine transform of a real grid, and its inverse, in place. This is the Fourier transform of the grid mirrored at
/// its border. The guarantees of RealTransform hold. 8 bytes per cell.
class CosineTransform {
public:
    /// @param cells     as in RealTransform. In space, the sum of forward() has a third cosine, and the factors are 8
    ///                  instead of 4.
    /// @param executor  runs the transforms; must outlive this
    /// @param spare     least size of spare(), as a count of numbers; 0, or at least the number of cells
    ///
    /// All cells are 0 at first.
    explicit CosineTransform(const std::array<int, 3>& cells, Executor& executor = inline_executor(),
                             std::size_t spare = 0);
    CosineTransform(CosineTransform&&) noexcept;
    CosineTransform& operator=(CosineTransform&&) noexcept;
    ~CosineTransform();

    /// Releases the memory. The next call must be grid() or spare(), which allocates the memory again, with all cells
    /// 0.
    void release_memory();

    /// Returns the cells of the grid [rows * columns], row by row. Before forward(), the cells hold values. After it,
    /// cell (x, y) holds the coefficient of frequency (x, y).
    std::span<double> grid();

    /// Returns memory that begins with the grid. Its size in numbers is the larger of `spare` and the number of cells.
    std::span<double> spare();

    /// Computes the DCT-II. Coefficient (x, y) is 4 sum over cells (i, j) of
    /// grid[j][i] cos(pi x (i + 1/2) / columns) cos(pi y (j + 1/2) / rows).
    void forward();

    /// Computes the DCT-III. forward() followed by backward() multiplies by 4 * columns * rows.
    void backward();

private:
    struct Grids;
    std::unique_ptr<Grids> grids_;
};

}  // namespace ccdt
