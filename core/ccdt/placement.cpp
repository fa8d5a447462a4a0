#include "core/ccdt/placement.h"

#include <string>

#include "core/ccdt/interior_sampler.h"
#include "core/random.h"

namespace ccdt {

std::optional<Error> place_sites(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
                                 std::uint64_t seed, double margin, const std::stop_token& stop) {
    constexpr int kAttempts = 16;  // where the domain covers half of a site's cell, one of 65,536 is still unplaced
    constexpr int kLastAttempts = 1000;
    constexpr std::size_t kStopStride = 4096;
    constexpr std::uint64_t kInteriorStream = 0x616e797768657265;  // keeps these draws apart from the start's
    const std::size_t sites = mesh.free_count();
    std::optional<InteriorSampler> interior;
    const auto place = [&](std::size_t site) {
        const auto vertex = static_cast<std::uint32_t>(site);
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            if (mesh.insert(vertex, attempt == 0 && !first.empty() ? first[site] : start.draw(site, attempt), margin))
                return true;
        }
        // Next to nothing of the site's cell lies in the domain.
        if (!interior) interior.emplace(mesh.inside_triangles());
        Random random(seed ^ kInteriorStream, site);
        for (int attempt = 0; attempt < kLastAttempts; ++attempt) {
            if (mesh.insert(vertex, interior->draw(random), margin)) return true;
        }
        return false;
    };
    // Coarse to fine: points far apart first keep the triangles round, neighbours in turn keep walks short.
    std::size_t placed = 0;
    for (std::size_t stride = 64, coarser = 0; stride >= 1; coarser = stride, stride /= 4) {
        for (std::size_t site = 0; site < sites; site += stride) {
            if (coarser != 0 && site % coarser == 0) continue;
            if (++placed % kStopStride == 0 && stop.stop_requested()) {
                return Error{ErrorCode::Stopped, "stopped before there was a result", ""};
            }
            if (!place(site)) {
                return Error{ErrorCode::Unusable,
                             "the domain is too thin to hold " + std::to_string(sites) + " sites strictly inside",
                             "sites"};
            }
        }
    }
    return std::nullopt;
}

}  // namespace ccdt
