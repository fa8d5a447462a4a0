#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>

#include "core/parallel/team.h"

namespace ccdt {

/// Smallest even product of powers of 2, 3 and 5 that is at least `least`: a side whose transform is fast.
/// @param least  at most 1e9
int good_size(double least);

/// Fourier transform of a real grid, and back.
///
/// The same input gives the same bits in every run, on every processor of one architecture and by any team. Using one
/// is for one thread at a time. Throws std::bad_alloc. O(n log n) for n cells, 16 bytes a cell.
class RealTransform {
public:
    /// @param columns, rows  >= 1; see good_size()
    /// @param team           does it; must outlive this
    /// @param spare          numbers that spare() is to hold
    /// All cells are 0.
    RealTransform(int columns, int rows, Team& team = alone(), std::size_t spare = 0);
    RealTransform(RealTransform&&) noexcept;
    RealTransform& operator=(RealTransform&&) noexcept;
    ~RealTransform();

    /// Gives the memory back. The next grid() or spare() brings it again, all cells 0; nothing else may come before.
    void rest();

    /// Cells of the grid [rows * columns], row by row.
    std::span<double> grid();

    /// Coefficients [rows * (columns / 2 + 1)], row by row: frequency (x, y) of the row y mod rows. The columns left
    /// out are the complex conjugates of those at (-x, -y).
    std::span<std::complex<double>> spectrum();
    std::span<const std::complex<double>> spectrum() const;

    /// Memory of the spectrum, which is of no use from backward() to forward(): as many numbers as were asked for.
    std::span<double> spare();

    /// spectrum[k] = sum over cells j of grid[j] e^(-2 pi i k.j), k.j = x_k x_j / columns + y_k y_j / rows. Keeps the
    /// grid.
    void forward();

    /// grid[j] = sum over all frequencies k of spectrum[k] e^(2 pi i k.j): forward(), then backward(), multiplies by
    /// columns * rows. Leaves nothing of use in the spectrum.
    void backward();

private:
    struct Grids;
    std::unique_ptr<Grids> grids_;
};

/// Cosine transform of a real grid, and back, in place: the Fourier transform of the grid mirrored at its border.
/// All that is said of RealTransform holds; 8 bytes a cell.
class CosineTransform {
public:
    /// @param columns, rows  >= 1; see good_size()
    /// @param team           does it; must outlive this
    /// @param spare          numbers that spare() is to hold; as many as cells at least, if any
    /// All cells are 0.
    CosineTransform(int columns, int rows, Team& team = alone(), std::size_t spare = 0);
    CosineTransform(CosineTransform&&) noexcept;
    CosineTransform& operator=(CosineTransform&&) noexcept;
    ~CosineTransform();

    /// Gives the memory back. The next grid() or spare() brings it again, all cells 0; nothing else may come before.
    void rest();

    /// Cells of the grid [rows * columns], row by row: values before forward(), coefficients of frequency (x, y) after
    /// it.
    std::span<double> grid();

    /// Memory that the grid is the beginning of: as many numbers as were asked for.
    std::span<double> spare();

    /// DCT-II: the coefficient (x, y) is 4 sum over cells (i, j) of
    /// grid[j][i] cos(pi x (i + 1/2) / columns) cos(pi y (j + 1/2) / rows).
    void forward();

    /// DCT-III: forward(), then backward(), multiplies by 4 * columns * rows.
    void backward();

private:
    struct Grids;
    std::unique_ptr<Grids> grids_;
};

}  // namespace ccdt
