// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/tetrahedron_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace ccdt {

namespace {

constexpr int kSweeps = 5;
constexpr double kStep = 0.1;             ///< first length of a move, relative to the mean length of edges
constexpr double kFarthest = 0.35;        ///< largest distance of a vertex from its first position, relative to edges
constexpr int kHalvings = 3;              ///< number of shorter moves that are tried next
constexpr double kGood = -0.766;          ///< quality of tetrahedra that are kept: no angle is below 40 degrees
constexpr double kMinGain = 1e-3;         ///< least gain of quality for which tetrahedra are replaced
constexpr std::size_t kLargestRing = 7;   ///< largest number of tetrahedra around an edge that is removed
constexpr double kInverted = -2;          ///< quality of a tetrahedron that is turned over
constexpr std::uint32_t kPerPoll = 1024;  ///< vertices or tetrahedra between polls of the stop token

/// Permutation i of the corners has corner i first and keeps the orientation.
constexpr std::array<std::array<std::size_t, 4>, 4> kFrom{{{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}}};

class Improver {
public:
    Improver(TetrahedronMesh& mesh, Point3 periods, const std::function<Point3(std::uint32_t, Point3)>& slide,
             const std::stop_token& stop)
        : vertices_(mesh.vertices),
          origins_(mesh.vertices),
          tetrahedra_(mesh.tetrahedra),
          periods_(periods),
          slide_(slide),
          stop_(stop) {}

    /// Moves each vertex along the negative gradient of its tetrahedra's energy, if this reduces the energy.
    void move_vertices() {
        list_tetrahedra();
        for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
            if (v % kPerPoll == 0 && stop_.stop_requested()) return;
            if (begins_[v] == begins_[v + 1]) continue;
            const Point3 from = vertices_[v];
            Point3 gradient;
            double edges = 0;
            const double before = energy(v, &gradient, &edges);
            const double steepness = length(gradient);
            if (!(steepness > 0) || !std::isfinite(before)) continue;
            for (double step = kStep * edges; step > kStep * edges / (1 << (kHalvings + 1)); step /= 2) {
                const Point3 to = slide_(v, from - step / steepness * gradient);
                vertices_[v] = to;
                if (length(vector(to, origins_[v])) <= kFarthest * edges && energy(v, nullptr, nullptr) < before) break;
                vertices_[v] = from;
            }
        }
    }

    /// Replaces the tetrahedra around edges wherever this improves the worst of them.
    void reconnect() {
        list_tetrahedra();
        removed_.assign(tetrahedra_.size(), false);
        const std::size_t count = tetrahedra_.size();
        for (std::uint32_t t = 0; t < count; ++t) {
            if (t % kPerPoll == 0 && stop_.stop_requested()) break;
            const Tetrahedron corners = tetrahedra_[t];
            if (removed_[t] || quality(corners) > kGood) continue;
            for (std::size_t i = 0; i < 4 && !removed_[t]; ++i) {
                for (std::size_t j = i + 1; j < 4 && !removed_[t]; ++j) remove_edge(corners[i], corners[j]);
            }
        }
        std::size_t kept = 0;
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            if (t >= count || !removed_[t]) tetrahedra_[kept++] = tetrahedra_[t];
        }
        tetrahedra_.resize(kept);
    }

private:
    Point3 vector(std::uint32_t from, std::uint32_t to) const { return vector(vertices_[from], vertices_[to]); }
    Point3 vector(Point3 from, Point3 to) const {
        Point3 v = to - from;
        if (periods_.x > 0) {
            v.x -= periods_.x * std::round(v.x / periods_.x);
            v.y -= periods_.y * std::round(v.y / periods_.y);
            v.z -= periods_.z * std::round(v.z / periods_.z);
        }
        return v;
    }

    /// Returns the sum over a vertex's tetrahedra of (sum of squared edges)^3 / volume^2, up to a factor; infinite if
    /// one of them is turned over. Also computes the gradient and the mean length of the vertex's edges if the pointers
    /// are not null.
    double energy(std::uint32_t v, Point3* gradient, double* mean_edge) const {
        double sum = 0, squares = 0;
        for (std::uint32_t k = begins_[v]; k < begins_[v + 1]; ++k) {
            const Tetrahedron& corners = tetrahedra_[lists_[k]];
            const auto& order = kFrom[static_cast<std::size_t>(std::ranges::find(corners, v) - corners.begin())];
            const Point3 a = vector(v, corners[order[1]]), b = vector(v, corners[order[2]]),
                         c = vector(v, corners[order[3]]);
            const Point3 ab = b - a, bc = c - b, ca = a - c, normal = cross(ab, ca);
            const double volume = -dot(normal, a), own = dot(a, a) + dot(b, b) + dot(c, c);
            if (!(volume > 0 && volume * volume > 0)) return std::numeric_limits<double>::infinity();
            const double size = own + dot(ab, ab) + dot(bc, bc) + dot(ca, ca);
            const double part = size * size * size / (volume * volume);
            sum += part;
            squares += own / 3;
            if (gradient == nullptr) continue;
            *gradient = *gradient - part * (6 / size * (a + b + c) + 2 / volume * normal);
        }
        if (mean_edge != nullptr) *mean_edge = std::sqrt(squares / (begins_[v + 1] - begins_[v]));
        return sum;
    }

    /// Returns the negative cosine of the smallest dihedral angle; kInverted if the tetrahedron is turned over.
    double quality(const Tetrahedron& corners) const {
        const Point3 a = vector(corners[0], corners[1]), b = vector(corners[0], corners[2]),
                     c = vector(corners[0], corners[3]);
        if (!(dot(cross(a, b), c) > 0)) return kInverted;
        std::array<Point3, 4> normals{cross(a, b), cross(b, c), cross(c, a), cross(c - a, b - a)};
        for (Point3& normal : normals) {
            const double size = length(normal);
            if (!(size > 0)) return kInverted;  // the squares of its coordinates are below the least number
            normal = 1 / size * normal;
        }
        double least = 1;
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = i + 1; j < 4; ++j) least = std::min(least, dot(normals[i], normals[j]));
        }
        return least;
    }

    /// Lists the tetrahedra at each vertex.
    void list_tetrahedra() {
        begins_.assign(vertices_.size() + 1, 0);
        for (const Tetrahedron& corners : tetrahedra_) {
            for (const std::uint32_t v : corners) ++begins_[v];
        }
        std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
        lists_.resize(begins_.back());
        for (std::size_t t = tetrahedra_.size(); t-- > 0;) {
            for (const std::uint32_t v : tetrahedra_[t]) lists_[--begins_[v]] = static_cast<std::uint32_t>(t);
        }
    }

    /// Removes an edge: replaces the tetrahedra around it by those over the best triangulation of the ring of vertices
    /// around it, by Klincsek's algorithm. Does nothing for edges on the surface, and where tetrahedra have been
    /// replaced since list_tetrahedra().
    void remove_edge(std::uint32_t a, std::uint32_t b) {
        std::array<std::uint32_t, kLargestRing> ring{}, next{}, around{};
        std::size_t count = 0;
        double before = 1;
        for (std::uint32_t k = begins_[a]; k < begins_[a + 1]; ++k) {
            const Tetrahedron& corners = tetrahedra_[lists_[k]];
            if (removed_[lists_[k]] || std::ranges::find(corners, b) == corners.end()) continue;
            if (count == kLargestRing) return;
            const auto& order = kFrom[static_cast<std::size_t>(std::ranges::find(corners, a) - corners.begin())];
            // The ring continues from c to d if the corners are a, b, c, d in an even order.
            std::size_t at = 1;
            while (corners[order[at]] != b) ++at;
            ring[count] = corners[order[at % 3 + 1]];
            next[count] = corners[order[(at + 1) % 3 + 1]];
            around[count++] = lists_[k];
            before = std::min(before, quality(corners));
        }
        if (count < 3) return;
        for (std::size_t i = 0; i < count; ++i) {
            std::size_t at = i + 1;
            if (i + 1 == count) {
                if (next[i] != ring[0]) return;
                break;
            }
            while (at < count && ring[at] != next[i]) ++at;
            if (at == count) return;
            std::swap(ring[i + 1], ring[at]);
            std::swap(next[i + 1], next[at]);
        }
        std::array<std::array<double, kLargestRing>, kLargestRing> best{};
        std::array<std::array<std::size_t, kLargestRing>, kLargestRing> split{};
        for (std::size_t span = 1; span < count; ++span) {
            for (std::size_t i = 0; i + span < count; ++i) {
                const std::size_t j = i + span;
                best[i][j] = span == 1 ? 1 : kInverted;
                for (std::size_t m = i + 1; m < j; ++m) {
                    const double limit = std::min(best[i][m], best[m][j]);
                    if (limit <= std::max(best[i][j], before)) continue;
                    const double own =
                        std::min(quality({ring[i], ring[m], ring[j], b}), quality({ring[m], ring[i], ring[j], a}));
                    if (std::min(own, limit) <= best[i][j]) continue;
                    best[i][j] = std::min(own, limit);
                    split[i][j] = m;
                }
            }
        }
        if (best[0][count - 1] < before + kMinGain) return;
        for (std::size_t i = 0; i < count; ++i) removed_[around[i]] = true;
        const auto add = [&](auto&& self, std::size_t i, std::size_t j) -> void {
            if (j - i < 2) return;
            const std::size_t m = split[i][j];
            tetrahedra_.push_back({ring[i], ring[m], ring[j], b});
            tetrahedra_.push_back({ring[m], ring[i], ring[j], a});
            self(self, i, m);
            self(self, m, j);
        };
        add(add, 0, count - 1);
    }

    std::vector<Point3>& vertices_;
    std::vector<Point3> origins_;
    std::vector<Tetrahedron>& tetrahedra_;
    Point3 periods_;
    const std::function<Point3(std::uint32_t, Point3)>& slide_;
    const std::stop_token& stop_;
    std::vector<std::uint32_t> begins_, lists_;  ///< tetrahedra at each vertex
    std::vector<bool> removed_;                  ///< [tetrahedra at the last list_tetrahedra()] whether it is replaced
};

}  // namespace

void improve_tetrahedra(TetrahedronMesh& mesh, Point3 periods,
                        const std::function<Point3(std::uint32_t vertex, Point3 to)>& slide,
                        const std::stop_token& stop) {
    Improver improver(mesh, periods, slide, stop);
    for (int sweep = 0; sweep < kSweeps && !stop.stop_requested(); ++sweep) {
        improver.move_vertices();
        improver.reconnect();
    }
}

}  // namespace ccdt
