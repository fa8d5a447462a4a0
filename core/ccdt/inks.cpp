#include "core/ccdt/inks.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <utility>

#include "core/ccdt/run.h"
#include "core/polish/ink_polish.h"
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
    void polish_together(const std::function<void()>& after);
    Density density_of_all() const;
    void report();
    InkPolishOptions polish_options() const;
    int polish_rounds() const;
    std::vector<Distribution> collect();

    struct InkRun {
        InkRun(const Domain& domain, const Density& wanted, const Options& own, const std::stop_token& stop)
            : density(wanted), options(own), run(domain, density, options, stop) {}

        const Density& density;
        Options options;
        Run run;
    };

    const Domain& domain_;
    const Options& options_;
    const Control& control_;
    std::vector<std::unique_ptr<InkRun>> inks_;  ///< [inks]; none for those without sites
    std::vector<InkRun*> runs_;                  ///< those that there are
    int round_ = 0;                              ///< of the polish
};

/// The first one keeps the seed, so that a single ink has the dots of a grey picture.
std::uint64_t seed_of(std::uint64_t seed, std::size_t number) {
    constexpr int kSeedBits = 53;
    return number == 0 ? seed : Random(seed, number).bits() >> (64 - kSeedBits);
}

InkRuns::InkRuns(const Domain& domain, std::span<const Density> densities, std::span<const std::size_t> sites,
                 const Options& options, const Control& control)
    : domain_(domain), options_(options), control_(control) {
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
    if (!runs_.front()->run.polish() || stopping()) return {};
    const auto after = [this] {
        ++round_;
        report();
    };
    if (runs_.size() == 1) {
        Run& run = runs_.front()->run;
        run.polish()->refine(run.mesh(), run.polish_options(), control_.stop, after);
    } else {
        polish_together(after);
    }
    for (InkRun* ink : runs_) {
        if (auto finished = ink->run.finish(); !finished) return finished;
    }
    return {};
}

void InkRuns::polish_together(const std::function<void()>& after) {
    std::vector<InkPolish::Ink> inks;
    for (InkRun* ink : runs_) inks.push_back({ink->run.polish(), &ink->run.mesh()});
    const Density together = density_of_all();
    InkPolish(domain_, together, std::move(inks), control_.stop).refine(polish_options(), control_.stop, after);
}

InkPolishOptions InkRuns::polish_options() const {
    InkPolishOptions settings;
    if (options_.quality == Quality::Best) {
        settings.rounds = 30;
        settings.rounds_even = 1;
        settings.even_rounds = 4;
    }
    return settings;
}

int InkRuns::polish_rounds() const {
    Run& first = runs_.front()->run;
    if (runs_.size() == 1 || !first.polish()) return first.polish_rounds();
    return polish_options().all_rounds();
}

/// Sites wanted in each cell.
Density InkRuns::density_of_all() const {
    const Density& first = runs_.front()->density;
    if (first.is_uniform()) return Density::uniform();
    std::vector<double> wanted(static_cast<std::size_t>(first.width()) * static_cast<std::size_t>(first.height()), 0);
    for (const InkRun* ink : runs_) {
        const double scale = static_cast<double>(ink->options.sites) / ink->density.total();
        auto cell = wanted.begin();
        for (int row = 0; row < first.height(); ++row) {
            for (int column = 0; column < first.width(); ++column) *cell++ += scale * ink->density.value(column, row);
        }
    }
    return Density::grid(first.width(), first.height(), std::span<const double>(wanted)).value();
}

void InkRuns::report() {
    if (!control_.progress) return;
    Progress progress{0, options_.iterations, 0, round_, polish_rounds()};
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

bool is_one_grid(std::span<const Density> densities, std::span<const std::size_t> sites) {
    const Density* first = nullptr;
    for (std::size_t ink = 0; ink < sites.size(); ++ink) {
        if (sites[ink] == 0) continue;
        const Density& density = densities[ink];
        if (!first) first = &density;
        if (density.width() != first->width() || density.height() != first->height()) return false;
    }
    return true;
}

}  // namespace

Result<std::vector<Distribution>> distribute_inks(const Domain& domain, std::span<const Density> densities,
                                                  std::span<const std::size_t> sites, const Options& options,
                                                  const Control& control) {
    assert(densities.size() == sites.size());
    std::size_t all = 0;
    for (const std::size_t count : sites) all += count;
    if (!is_one_grid(densities, sites)) {
        return failure(ErrorCode::Malformed, "the densities of all inks must have one grid", "density");
    }
    Options whole = options;
    whole.sites = all;
    if (auto checked = check(whole); !checked) return tl::unexpected(checked.error());
    return InkRuns(domain, densities, sites, options, control).execute();
}

}  // namespace ccdt
