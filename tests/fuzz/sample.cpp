// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample_parser.h"

#include <algorithm>
#include <utility>

#include "api/image/image_codec.h"
#include "api/input/polygon_reader.h"
#include "api/json/json_document.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/shape_checks.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 100'000, .max_pixels = 4'096};
constexpr std::size_t kMaxCorners = 64;  ///< maximum for which a request is computed
constexpr std::size_t kMaxSites = 8;

Result<Density> density_of(const api::SampleRequest& request) {
    if (const auto* image = std::get_if<api::DensityImage>(&request.density))
        CCDT_CHECK(image->file.header.pixels() <= kLimits.max_pixels);
    const auto* grid = std::get_if<api::DensityGrid>(&request.density);
    if (grid == nullptr) return Density::uniform();
    CCDT_CHECK(grid->width > 0 && grid->height > 0);
    CCDT_CHECK(grid->values.size() == static_cast<std::size_t>(grid->width) * static_cast<std::size_t>(grid->height));
    return Density::grid(grid->width, grid->height, std::span<const double>(grid->values));
}

Result<RepairedDomain> domain_of(const api::SampleRequest& request, std::string_view body) {
    const auto valid = [](Domain&& domain) { return RepairedDomain{std::move(domain), {}}; };
    if (const auto* rectangle = std::get_if<api::Rectangle>(&request.region.domain)) {
        CCDT_CHECK(rectangle->width > 0 && rectangle->height > 0);
        return api::make_domain(*rectangle).map(valid);
    }
    const auto& polygon = std::get<api::PolygonInput>(request.region.domain);
    auto domain = request.region.on_invalid == api::OnInvalid::Repair ? Domain::repair(polygon.parts)
                                                                      : Domain::create(polygon.parts).map(valid);
    if (!domain) {
        check_location(domain.error(), polygon.parts);
        domain.error().field = polygon.pointer_to(domain.error().field);
        check_error(domain.error(), body);
    }
    return domain;
}

void check_options(const api::SampleRequest& request) {
    const Options& run = request.run;
    CCDT_CHECK(run.sites >= 1 && run.sites <= kLimits.max_sites);
    CCDT_CHECK(run.iterations >= 0 && run.iterations <= 1000);
    CCDT_CHECK(run.passes >= 1 && run.passes <= 100);
    CCDT_CHECK(run.seed < std::uint64_t{1} << 53);
    CCDT_CHECK(!run.tolerance || *run.tolerance > 0);
}

/// Computes a request with fewer sites, iterations and passes, because long computations test no more.
void run(const api::SampleRequest& request, const RepairedDomain& made, const Density& density) {
    const auto& [domain, repairs] = made;
    Options options = request.run;
    options.sites = std::min(options.sites, kMaxSites);
    options.iterations = std::min(options.iterations, 1);
    options.passes = std::min(options.passes, 2);
    const auto* polygon = std::get_if<api::PolygonInput>(&request.region.domain);
    if (polygon != nullptr && polygon->corner_count() > kMaxCorners) return;
    const auto parts = polygon == nullptr || !repairs.empty() ? std::vector<PolygonPart>() : polygon->parts;
    if (request.method == &api::methods().front()) return check_distribution(domain, parts, density, options);
    const auto placed = request.method->run(domain, density, options, {});
    if (placed) {
        check_points(placed->points, options.sites, domain, parts);
    } else {
        check_error(placed.error());
    }
}

void check_request(const api::SampleRequest& request, std::string_view body) {
    check_options(request);
    const auto domain = domain_of(request, body);
    if (!domain) return check_error(domain.error(), body);
    check_domain(domain->domain);
    const auto density = density_of(request);
    if (!density) return check_error(density.error());
    run(request, *domain, *density);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as the body of a request to /sample, and computes it with reduced options. If the body is GeoJSON,
/// the options are in the query.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto body = fuzz::text_of(data, size);
    const auto document = api::JsonDocument::parse_features(body);
    std::vector<api::TextOption> options;
    if (document && api::is_geojson(document->root())) options = {{"sites", "7"}, {"quality", "draft"}};
    const auto request = api::parse_sample(body, options, {}, fuzz::kLimits);
    if (request) {
        fuzz::check_request(*request, body);
    } else {
        fuzz::check_error(request.error(), body);
    }
    return 0;
}
