#include "core/ccdt/ccdt.h"

#include "core/ccdt/run.h"

namespace ccdt {

Result<Distribution> distribute(const Domain& domain, const Density& density, const Options& options,
                                const Control& control) {
    if (auto checked = check(options); !checked) return tl::unexpected(checked.error());
    Run run(domain, density, options, control.stop);
    if (auto started = run.start(); !started) return tl::unexpected(started.error());
    Progress progress{0, options.iterations, 0, 0, run.polish_rounds()};
    const auto report = [&] {
        progress.iteration = run.iterations();
        progress.variation = run.variation();
        if (control.progress) control.progress(progress);
    };
    report();
    while (run.goes_on()) {
        if (run.iterate()) report();
    }
    if (Polish* polish = run.polish(); polish && !control.stop.stop_requested()) {
        polish->refine(run.mesh(), run.polish_options(), control.stop, [&] {
            ++progress.round;
            report();
        });
        if (auto finished = run.finish(); !finished) return tl::unexpected(finished.error());
    }
    return run.collect();
}

}  // namespace ccdt
