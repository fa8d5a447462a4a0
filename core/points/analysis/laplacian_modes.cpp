// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/laplacian_modes.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/random.h"

namespace ccdt {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxRestarts = 100;
/// Residual of an eigenvector relative to its eigenvalue. It bounds the share of other modes, whose power may be 1, to
/// 1e-10.
constexpr double kTolerance = 1e-5;
/// Least area of a triangle, relative to the sum of its squared sides, in the stiffness matrix. It bounds the
/// cotangents of needles, which would make the matrix singular.
constexpr double kMinArea = 1e-9;

struct Matrices {
    Sparse stiffness, mass;
};

Matrices assemble(std::span<const Point3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles) {
    Triplets stiffness, mass;
    stiffness.reserve(12 * triangles.size());
    mass.reserve(12 * triangles.size());
    for (const auto& corners : triangles) {
        std::array<Point3, 3> sides;  // side i is opposite to corner i
        double squares = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            sides[i] = vertices[corners[(i + 2) % 3]] - vertices[corners[(i + 1) % 3]];
            squares += dot(sides[i], sides[i]);
        }
        const double area = std::max(length(cross(sides[0], sides[1])) / 2, kMinArea * squares);
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
            const auto a = static_cast<int>(corners[j]), b = static_cast<int>(corners[k]);
            const double half_cotangent = -dot(sides[j], sides[k]) / (4 * area);
            for (const auto& [row, column, sign] : {std::array{a, b, -1}, {b, a, -1}, {a, a, 1}, {b, b, 1}}) {
                stiffness.emplace_back(row, column, sign * half_cotangent);
                mass.emplace_back(row, column, area / 12);
            }
        }
    }
    const auto size = static_cast<Index>(vertices.size());
    Matrices matrices{Sparse(size, size), Sparse(size, size)};
    matrices.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
    matrices.mass.setFromTriplets(mass.begin(), mass.end());
    return matrices;  // NOLINT(clang-analyzer-unix.Malloc): Eigen frees what it moves
}

/// Returns a negative shift whose magnitude is that of the lowest eigenvalue. The shifted matrix is positive definite.
double find_shift(std::span<const Point3> vertices) {
    double reach = 0;
    for (const Point3& p : vertices) reach = std::max(reach, length(p - vertices.front()));
    return -1 / (reach * reach);
}

/// Finds the eigenvectors v of (stiffness - shift mass)^-1 mass with the largest eigenvalues, by Lanczos' method for
/// blocks of vectors. A block finds all eigenvectors of a multiple eigenvalue, which symmetric surfaces have. Vectors
/// are orthonormal with respect to mass, and orthogonal to the constant.
class BlockLanczos {
public:
    BlockLanczos(const Matrices& matrices, double shift, Index modes)
        : mass_(matrices.mass), weights_(mass_ * VectorXd::Ones(mass_.rows())), modes_(modes) {
        factors_.compute(Sparse(matrices.stiffness - shift * mass_));
        // The largest multiplicity among the lowest eigenvalues of a sphere is 2 sqrt(modes) + 1.
        block_ = std::min(modes, 2 * static_cast<Index>(std::sqrt(static_cast<double>(modes))) + 2);
        basis_.resize(mass_.rows(), (2 * modes / block_ + 2) * block_);
        projected_ = MatrixXd::Zero(basis_.cols(), basis_.cols());
        next_.resize(mass_.rows(), block_);
        Random random(0, 0);
        for (double& value : next_.reshaped()) value = random.uniform() - 0.5;
        orthonormalise(next_);
    }

    /// Extends the basis until it is full, then replaces it by its best part. Returns whether all modes have converged.
    bool run(const std::stop_token& stop) {
        while (size_ + block_ <= basis_.cols()) {
            if (stop.stop_requested()) return false;
            extend();
        }
        const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(projected_.topLeftCorner(size_, size_));
        // Eigenvalues come in ascending order.
        const Index kept = modes_ + block_;
        const MatrixXd ritz = solver.eigenvectors().rightCols(kept).rowwise().reverse();
        values_ = solver.eigenvalues().tail(kept).reverse();
        const VectorXd residuals = (residual_ * ritz.bottomRows(block_)).colwise().norm();
        basis_.leftCols(kept) = (basis_.leftCols(size_) * ritz).eval();
        projected_.setZero();
        projected_.diagonal().head(kept) = values_;
        size_ = kept;
        return (residuals.head(modes_).array() < kTolerance * values_.head(modes_).array()).all();
    }

    bool is_valid() const { return factors_.info() == Eigen::Success; }
    double area() const { return weights_.sum(); }
    auto values() const { return values_.head(modes_); }
    auto vectors() const { return basis_.leftCols(modes_); }

private:
    /// Appends the next block to the basis and computes the one after it.
    void extend() {
        basis_.middleCols(size_, block_) = next_;
        const Index before = size_;
        size_ += block_;
        next_ = factors_.solve(mass_ * next_);
        const MatrixXd image = mass_ * next_;
        const MatrixXd products = basis_.leftCols(size_).transpose() * image;
        projected_.block(0, before, size_, block_) = products;
        projected_.block(before, 0, block_, size_) = products.transpose();
        next_.noalias() -= basis_.leftCols(size_) * products;
        normalise(next_);
        orthonormalise(next_);
        residual_ = next_.transpose() * image;
    }

    /// Makes the columns of a block orthonormal, and orthogonal to the basis and to the constant. If they are
    /// nearly orthogonal already, the errors of the result are those of rounding.
    void orthonormalise(MatrixXd& block) const {
        block.rowwise() -= weights_.transpose() * block / area();
        const MatrixXd products = basis_.leftCols(size_).transpose() * (mass_ * block);
        block.noalias() -= basis_.leftCols(size_) * products;
        normalise(block);
        normalise(block);
    }

    /// Makes the columns of a block orthonormal.
    void normalise(MatrixXd& block) const {
        block.colwise().normalize();
        const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(block.transpose() * (mass_ * block));
        // Directions that are lost to rounding become arbitrary ones.
        const double least = 1e-14 * gram.eigenvalues().maxCoeff();
        const VectorXd scales = gram.eigenvalues().cwiseMax(least).cwiseSqrt().cwiseInverse();
        block = block * gram.eigenvectors() * scales.asDiagonal();
    }

    const Sparse& mass_;
    VectorXd weights_;  ///< [vertices] integrals of the linear functions that are 1 at one vertex
    Eigen::SimplicialLDLT<Sparse> factors_;
    Index modes_;
    Index block_ = 0;
    Index size_ = 0;      ///< number of columns of the basis in use
    MatrixXd basis_;      ///< [vertices][columns]
    MatrixXd projected_;  ///< [columns][columns] the operator in the basis
    MatrixXd next_;       ///< [vertices][block]
    MatrixXd residual_;   ///< [block][block] part of the operator from the last block of the basis to the next one
    VectorXd values_;     ///< eigenvalues of the operator, descending
};

}  // namespace

Result<LaplacianModes> find_laplacian_modes(std::span<const Point3> vertices,
                                            std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t count,
                                            const std::stop_token& stop) {
    assert(count >= 1 && 5 * count <= vertices.size());
    const Matrices matrices = assemble(vertices, triangles);
    const double shift = find_shift(vertices);
    BlockLanczos solver(matrices, shift, static_cast<Index>(count));
    bool has_converged = false;
    for (int i = 0; i < kMaxRestarts && solver.is_valid() && !has_converged; ++i) {
        has_converged = solver.run(stop);
        if (stop.stop_requested()) return failure(ErrorCode::Stopped, "the computation of modes was stopped");
    }
    if (!has_converged) return failure(ErrorCode::Unusable, "the modes of the surface did not converge");
    LaplacianModes modes;
    for (const double value : solver.values()) modes.eigenvalues.push_back(1 / value + shift);
    modes.values.resize(count * vertices.size());
    const auto rows = static_cast<Index>(vertices.size());
    Eigen::Map<MatrixXd>(modes.values.data(), rows, static_cast<Index>(count)) =
        std::sqrt(solver.area()) * solver.vectors();
    return modes;
}

}  // namespace ccdt
