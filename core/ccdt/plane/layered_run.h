// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/distribution.h"

namespace ccdt {

/// Layers of sites with common iterations and a common polish: inks, or the classes of a dot map.
/// @tparam Layer  Construction or DotLayer
template <class Layer>
struct LayeredRun {
    const Options& options;
    const Control& control;
    std::vector<std::unique_ptr<Layer>> layers = {};  ///< null for layers without sites
    std::vector<Layer*> used = {};                    ///< the layers with sites
    std::optional<PolishSettings> settings = {};      ///< none if there is no polish
    int round = 0;                                    ///< rounds of the polish completed

    bool stopping() const { return control.stop.stop_requested(); }

    Result<void> start() {
        for (Layer* layer : used) {
            if (auto started = layer->start(); !started) return started;
        }
        report();
        return {};
    }

    /// @param iterate  runs the next iteration of a layer
    template <class Iterate>
    void iterate(Iterate&& iterate) {
        while (std::ranges::any_of(used, &Layer::has_next_iteration)) {
            for (Layer* layer : used) {
                if (layer->has_next_iteration()) iterate(*layer);
            }
            if (!stopping()) report();
        }
    }

    void finish_round() {
        ++round;
        report();
    }

    void report() const {
        if (!control.progress) return;
        Progress progress{0, options.iterations, {}, round, settings ? settings->all_rounds() : 0};
        for (const Layer* layer : used) {
            progress.iteration = std::max(progress.iteration, layer->iterations());
            progress.variation = std::max(progress.variation, std::optional(layer->variation()));
        }
        control.progress(progress);
    }
};

}  // namespace ccdt
