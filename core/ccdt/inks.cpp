#include "core/ccdt/inks.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <utility>

#include "core/ccdt/run.h"
#include "core/random.h"

namespace ccdt {

namespace {

/// The runs of all inks that have sites, each as in distribute(), in step.
class InkRuns {
public:
    InkRuns(const Domain& domain, std::span<const Density> densities, std::span<const std::size_t> sites,
            const Options& options, const Control& control);

    Result<std::vector<Distribution>> execute();

private:
    bool stopping() const { return control_.stop.stop_requested(); }
    Result<void> start();
    void iterate();
    Result<void> polish();
    void report() const;
    std::vector<Distribution> collect();

    struct InkRun {
        InkRun(const Domain& domain, const Density& density, const Options& own, const std::stop_token& stop)
            : options(own), run(domain, density, options, stop) {}

        Options options;
        Run run;
    };

    const Control& control_;
    int iterations_;
    std::vector<std::unique_ptr<InkRun>> inks_;  ///< [inks]; none for those without sites
    std::vector<InkRun*> runs_;                  ///< those that there are
};

/// The first one keeps the seed, so that a single ink has the dots of a grey picture.
std::uint64_t seed_of(std::uint64_t seed, std::size_t number) {
    constexpr int kSeedBits = 53;
    return number == 0 ? seed : Random(seed, number).bits() >> (64 - kSeedBits);
}

InkRuns::InkRuns(const Domain& domain, std::span<const Density> densities, std::span<const std::size_t> sites,
                 const Options& options, const Control& control)
    : control_(control), iterations_(options.iterations) {
    for (std::size_t ink = 0; ink < sites.size(); ++ink) {
        inks_.emplace_back();
        if (sites[ink] == 0) continue;
        Options own = options;
        own.sites = sites[ink];
        own.seed = seed_of(options.seed, runs_.size());
        inks_.back() = std::make_unique<InkRun>(domain, densities[ink], own, control.stop);
        runs_.push_back(inks_.back().get());
    }
}

Result<std::vector<Distribution>> InkRuns::execute() {
    if (auto started = start(); !started) return tl::unexpected(started.error());
    iterate();
    if (auto polished = polish(); !polished) return tl::unexpected(polished.error());
    return collect();
}

Result<void> InkRuns::start() {
    for (InkRun* ink : runs_) {
        if (auto started = ink->run.start(); !started) return started;
    }
    report();
    return {};
}

void InkRuns::iterate() {
    const auto goes_on = [](const InkRun* ink) { return ink->run.goes_on(); };
    while (std::ranges::any_of(runs_, goes_on)) {
        for (InkRun* ink : runs_) {
            if (goes_on(ink)) ink->run.iterate();
        }
        if (!stopping()) report();
    }
}

Result<void> InkRuns::polish() {
    for (InkRun* ink : runs_) {
        Polish* polish = ink->run.polish();
        if (!polish || stopping()) continue;
        polish->refine(ink->run.mesh(), ink->run.polish_options(), control_.stop);
        if (auto finished = ink->run.finish(); !finished) return finished;
    }
    return {};
}

void InkRuns::report() const {
    if (!control_.progress) return;
    Progress progress{0, iterations_, 0};
    for (const InkRun* ink : runs_) {
        progress.iteration = std::max(progress.iteration, ink->run.iterations());
        progress.variation = std::max(progress.variation, ink->run.variation());
    }
    control_.progress(progress);
}

std::vector<Distribution> InkRuns::collect() {
    std::vector<Distribution> distributions;
    for (const auto& ink : inks_) {
        distributions.push_back(ink ? ink->run.collect() : Distribution{});
        if (!ink) distributions.back().trace = {0};
    }
    return distributions;
}

}  // namespace

Result<std::vector<Distribution>> distribute_inks(const Domain& domain, std::span<const Density> densities,
                                                  std::span<const std::size_t> sites, const Options& options,
                                                  const Control& control) {
    assert(densities.size() == sites.size());
    std::size_t all = 0;
    for (const std::size_t count : sites) all += count;
    Options whole = options;
    whole.sites = all;
    if (auto checked = check(whole); !checked) return tl::unexpected(checked.error());
    return InkRuns(domain, densities, sites, options, control).execute();
}

}  // namespace ccdt
