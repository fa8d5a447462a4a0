// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/random_sites.h"

#include "core/baselines/site_mesh.h"

namespace ccdt {

Result<Distribution> random_sites(const Domain& domain, const Density& density, const Options& options,
                                  const Control& control) {
    Options start = options;
    start.start = Start::Random;
    start.iterations = 0;
    auto sites = SiteMesh::create(domain, density, start, control.stop);
    if (!sites) return tl::unexpected(sites.error());
    return sites->iterate(start, control, [] { return false; });
}

}  // namespace ccdt
