#include "core/ccdt/placement.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/ccdt/interior_sampler.h"
#include "core/random.h"

namespace ccdt {

namespace {

/// Inserts one site after the other.
class Placement {
public:
    Placement(Triangulation& mesh, std::span<const Point> first, const StartSites& start, std::vector<std::size_t> room,
              std::uint64_t seed, double margin)
        : mesh_(mesh), first_(first), start_(start), room_(std::move(room)), seed_(seed), margin_(margin) {}

    /// @returns  false if there is no place for it
    bool place(std::uint32_t site) {
        constexpr int kAttempts = 16;  // where the domain covers half of a site's cell, one of 65,536 is still unplaced
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            if (insert(site, attempt == 0 && !first_.empty() ? first_[site] : start_.draw(site, attempt))) return true;
        }
        // Next to nothing of the site's cell lies where there is room.
        while (!room_.empty()) {
            const auto most = std::ranges::max_element(room_);
            if (*most == 0) {
                room_.clear();
            } else if (place_in(static_cast<std::uint32_t>(most - room_.begin()), site)) {
                return true;
            } else {
                *most = 0;
            }
        }
        return place_in(Triangulation::kNone, site);
    }

private:
    bool insert(std::uint32_t site, Point p) {
        if (room_.empty()) return mesh_.insert(site, p, margin_);
        const std::uint32_t part = mesh_.part_at(p);
        if (part == Triangulation::kNone || room_[part] == 0 || !mesh_.insert(site, p, margin_)) return false;
        --room_[part];
        return true;
    }

    /// Places a site anywhere in a part; of kNone, in the domain.
    bool place_in(std::uint32_t part, std::uint32_t site) {
        constexpr int kAttempts = 1000;
        constexpr std::uint64_t kStream = 0x616e797768657265;  // keeps these draws apart from the start's
        if (!interior_ || part_ != part) interior_.emplace(mesh_.inside_triangles(part_ = part));
        Random random(seed_ ^ kStream, site);
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            if (insert(site, interior_->draw(random))) return true;
        }
        return false;
    }

    Triangulation& mesh_;
    std::span<const Point> first_;
    const StartSites& start_;
    std::vector<std::size_t> room_;
    std::uint64_t seed_;
    double margin_;
    std::optional<InteriorSampler> interior_;  ///< of one part
    std::uint32_t part_ = Triangulation::kNone;
};

}  // namespace

std::optional<Error> place_sites(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
                                 std::vector<std::size_t> room, std::uint64_t seed, double margin,
                                 const std::stop_token& stop) {
    constexpr std::size_t kStopStride = 4096;
    const std::size_t sites = mesh.free_count();
    Placement placement(mesh, first, start, std::move(room), seed, margin);
    // Coarse to fine: points far apart first keep the triangles round, neighbours in turn keep walks short.
    std::size_t placed = 0;
    for (std::size_t stride = 64, coarser = 0; stride >= 1; coarser = stride, stride /= 4) {
        for (std::size_t site = 0; site < sites; site += stride) {
            if (coarser != 0 && site % coarser == 0) continue;
            if (++placed % kStopStride == 0 && stop.stop_requested()) {
                return Error{ErrorCode::Stopped, "stopped before there was a result", ""};
            }
            if (!placement.place(static_cast<std::uint32_t>(site))) {
                return Error{ErrorCode::Unusable,
                             "the domain is too thin to hold " + std::to_string(sites) + " sites strictly inside",
                             "sites"};
            }
        }
    }
    return std::nullopt;
}

}  // namespace ccdt
