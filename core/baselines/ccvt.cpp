// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/ccvt.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/baselines/equal_cells.h"
#include "core/baselines/mass_samples.h"
#include "core/baselines/periodic_images.h"
#include "core/baselines/site_mesh.h"

namespace ccdt {

namespace {

std::size_t samples_per_site(std::size_t sites) {
    return std::clamp((std::size_t{1} << 18) / sites, std::size_t{256}, std::size_t{1024});
}

EqualCells make_cells(const SiteMesh& sites, std::uint64_t seed, const std::stop_token& stop) {
    const std::size_t count = samples_per_site(sites.sites().size()) * sites.sites().size();
    return EqualCells(mass_samples(sites.domain(), sites.mesh(), sites.density(), count, seed, stop), sites.sites(),
                      PeriodicImages(sites.domain()), stop);
}

}  // namespace

Result<Distribution> ccvt(const Domain& domain, const Density& density, const Options& options,
                          const Control& control) {
    auto sites = SiteMesh::create(domain, density, options, control.stop);
    if (!sites) return tl::unexpected(sites.error());
    EqualCells cells = make_cells(*sites, options.seed, control.stop);
    bool is_first = true;
    return sites->iterate(options, control, [&] {
        const bool swapped = cells.sweep(control.stop);
        const bool moves = swapped || std::exchange(is_first, false);
        return moves && !control.stop.stop_requested() && sites->move(cells.centroids());
    });
}

}  // namespace ccdt
