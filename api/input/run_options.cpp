#include "api/input/run_options.h"

#include <algorithm>

namespace ccdt::api {
namespace {

constexpr std::uint64_t kMaxIterations = 1000;
constexpr std::uint64_t kMaxPasses = 100;

tl::unexpected<Error> stopped() {
    return failure(ErrorCode::Stopped, "the computation was stopped");
}

}  // namespace

Result<void> read_seed(const Input& input, Options& options) {
    return assign(options.seed, read_integer(input, 0, kMaxInteger));
}

Result<void> read_iterations(const Input& input, Options& options) {
    return assign(options.iterations, read_integer(input, 0, kMaxIterations));
}

Result<void> read_passes(const Input& input, Options& options) {
    return assign(options.passes, read_integer(input, 1, kMaxPasses));
}

Result<void> read_quality(const Input& input, Options& options) {
    static constexpr std::string_view kWords[] = {"draft", "standard", "best"};
    static constexpr Quality kQualities[] = {Quality::Draft, Quality::Standard, Quality::Best};
    const auto index = read_choice(input, kWords);
    if (!index) return tl::unexpected(index.error());
    options.quality = kQualities[*index];
    return {};
}

Result<void> read_on_deadline(const Input& input, OnStop& on_stop) {
    static constexpr std::string_view kWords[] = {"error", "partial"};
    const auto index = read_choice(input, kWords);
    if (!index) return tl::unexpected(index.error());
    on_stop = *index == 0 ? OnStop::Error : OnStop::Partial;
    return {};
}

Result<Distribution> distribute_all(const Domain& domain, const Density& density, const Options& options,
                                    const Control& control, OnStop on_stop, Method method) {
    auto distribution = distribute_by(method, domain, density, options, control);
    if (distribution && distribution->stopped && on_stop == OnStop::Error) return stopped();
    return distribution;
}

Result<std::vector<Distribution>> distribute_all_inks(const Domain& domain, std::span<const Density> densities,
                                                      std::span<const std::size_t> sites, const Options& options,
                                                      const Control& control, OnStop on_stop) {
    auto inks = distribute_inks(domain, densities, sites, options, control);
    if (inks && on_stop == OnStop::Error && std::ranges::any_of(*inks, &Distribution::stopped)) return stopped();
    return inks;
}

std::stop_token stop_of_writing(const Control& control, OnStop on_stop) {
    return on_stop == OnStop::Partial ? std::stop_token() : control.stop;
}

Result<void> check_stop(const std::stop_token& stop) {
    if (stop.stop_requested()) return stopped();
    return {};
}

}  // namespace ccdt::api
