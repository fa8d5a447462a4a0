#include "api/method.h"

#include <limits>
#include <string>
#include <utility>

#include "core/baselines/ccvt.h"
#include "core/baselines/cvt.h"
#include "core/baselines/odt.h"
#include "core/baselines/random_sites.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();  ///< but the server's

struct Traits {
    std::string_view name;
    decltype(&distribute) run;
    std::size_t max_sites;
    int iterations;    ///< unless given
    GivenOptions has;  ///< options that it has
};

constexpr GivenOptions kAll = {.iterations = true, .passes = true, .quality = true, .tolerance = true};
constexpr GivenOptions kIterative = {.iterations = true, .passes = false, .quality = false, .tolerance = true};

/// In the order of Method.
constexpr std::array<Traits, 5> kTraits = {{
    {"ccdt", distribute, kNoLimit, Options{}.iterations, kAll},
    {"cvt", cvt, 50'000, kCvtIterations, kIterative},
    {"odt", odt, 500'000, kOdtIterations, kIterative},
    {"ccvt", ccvt, 20'000, kCcvtIterations, kIterative},
    {"random", random_sites, kNoLimit, 0, {}},
}};

constexpr std::array<std::pair<std::string_view, bool GivenOptions::*>, 4> kOptions = {
    {{"iterations", &GivenOptions::iterations},
     {"passes", &GivenOptions::passes},
     {"quality", &GivenOptions::quality},
     {"tolerance", &GivenOptions::tolerance}}};

const Traits& traits_of(Method method) {
    return kTraits[static_cast<std::size_t>(method)];
}

}  // namespace

std::string_view name_of(Method method) {
    return traits_of(method).name;
}

Result<Method> read_method(const Input& input) {
    std::array<std::string_view, kTraits.size()> names;
    for (std::size_t i = 0; i < names.size(); ++i) names[i] = kTraits[i].name;
    Method method{};
    const auto read = assign(method, read_choice(input, names));
    if (!read) return tl::unexpected(read.error());
    return method;
}

Result<void> settle_method(Method method, const GivenOptions& given, Options& options) {
    const Traits& traits = traits_of(method);
    for (const auto& [option, member] : kOptions) {
        if (!(given.*member) || traits.has.*member) continue;
        return failure(ErrorCode::Malformed,
                       std::string(option) + " is no option of method " + std::string(traits.name),
                       '/' + std::string(option));
    }
    if (options.sites > traits.max_sites) {
        return failure(ErrorCode::LimitExceeded,
                       "sites is " + std::to_string(options.sites) + "; the limit of method " +
                           std::string(traits.name) + " is " + std::to_string(traits.max_sites),
                       "/sites");
    }
    if (!given.iterations) options.iterations = traits.iterations;
    return {};
}

Result<Distribution> distribute_by(Method method, const Domain& domain, const Density& density, const Options& options,
                                   const Control& control) {
    return traits_of(method).run(domain, density, options, control);
}

}  // namespace ccdt::api
