// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <limits>

#include "tests/fuzz/checks.h"
#include "tests/fuzz/shape_checks.h"
#include "tests/support/shapes.h"

namespace ccdt::fuzz {
namespace {

using Parts = std::vector<PolygonPart>;

constexpr std::uint8_t kNewPart = 255;
constexpr std::uint8_t kNewHole = 254;

/// Encoding of a vertex, given by the last two bits of the byte before the vertex.
enum class Vertex { Grid, Neighbour, Fine, Any };

Point nudged(Point p, int x, int y) {
    const auto nudge = [](double value, int steps) {
        const double end = steps < 0 ? -std::numeric_limits<double>::max() : std::numeric_limits<double>::max();
        for (int i = 0; i < std::abs(steps); ++i) value = std::nextafter(value, end);
        return value;
    };
    return {nudge(p.x, x), nudge(p.y, y)};
}

/// Reads a vertex. Vertices on the small grid coincide often, and their edges overlap. Neighbour yields a vertex a few
/// doubles away from an earlier vertex.
Point read_vertex(Vertex kind, Bytes& input, Point before) {
    switch (kind) {
        case Vertex::Grid: {
            const auto x = input.take<std::int8_t>();
            const auto y = input.take<std::int8_t>();
            return {static_cast<double>(x), static_cast<double>(y)};
        }
        case Vertex::Neighbour: {
            const auto x = input.take<std::int8_t>();
            const auto y = input.take<std::int8_t>();
            return nudged(before, x, y);
        }
        case Vertex::Fine: {
            const auto x = input.take<std::int16_t>();
            const auto y = input.take<std::int16_t>();
            return {x / 256.0, y / 256.0};
        }
        case Vertex::Any: {
            const auto x = input.take<double>();
            const auto y = input.take<double>();
            return {x, y};
        }
    }
    return {};
}

Parts read_parts(Bytes& input) {
    Parts parts(1);
    Ring vertices;
    while (!input.empty()) {
        const auto tag = input.take<std::uint8_t>();
        if (tag == kNewPart) {
            parts.emplace_back();
        } else if (tag == kNewHole) {
            parts.back().holes.emplace_back();
        } else {
            const std::size_t back = tag / 4U;
            const Point before = back < vertices.size() ? vertices[vertices.size() - 1 - back] : Point{};
            vertices.push_back(read_vertex(static_cast<Vertex>(tag % 4U), input, before));
            Ring& ring = parts.back().holes.empty() ? parts.back().outer : parts.back().holes.back();
            ring.push_back(vertices.back());
        }
    }
    return parts;
}

/// Reads options. The number of sites is small, because the shape of the domain is tested.
Options read_options(Bytes& input) {
    const auto bits = input.take<std::uint8_t>();
    Options options;
    options.sites = input.take<std::uint8_t>() % 24U + 1;
    options.seed = input.take<std::uint8_t>();
    options.iterations = bits % 3U;
    options.passes = 2;
    options.quality = static_cast<Quality>(bits / 4U % 3);
    return options;
}

Result<Density> read_density(Bytes& input) {
    const auto kind = input.take<std::uint8_t>();
    if (kind % 2U == 0) return Density::uniform();
    std::array<double, 4> values;
    for (double& value : values) value = input.take<std::uint8_t>();
    return Density::grid(2, 2, std::span<const double>(values));
}

bool is_far_from_overflow(const Parts& parts) {
    const auto fits = [](double value) {
        const double size = std::abs(value);
        return value == 0 || (size > 1e-90 && size < 1e90);
    };
    for (const auto& part : parts) {
        std::vector<Ring> rings = part.holes;
        rings.push_back(part.outer);
        for (const Ring& ring : rings) {
            for (const Point& p : ring) {
                if (!fits(p.x) || !fits(p.y)) return false;
            }
        }
    }
    return true;
}

/// Checks that scaling by a power of two, which is exact, changes nothing.
void check_scaled(const Parts& parts, const Result<Domain>& domain) {
    if (!is_far_from_overflow(parts)) return;
    for (const double factor : {0.5, 1024.0}) {
        const auto scaled = Domain::create(test::scaled(parts, factor));
        CCDT_CHECK(scaled.has_value() == domain.has_value());
        if (scaled) CCDT_CHECK(scaled->rings() == domain->rings());
        if (!scaled) CCDT_CHECK(scaled.error().field == domain.error().field);
    }
}

void check_polygon(const Parts& parts, const Density& density, const Options& options) {
    const auto domain = Domain::create(parts);
    check_scaled(parts, domain);
    if (!domain) return check_location(domain.error(), parts);
    check_domain(*domain);
    check_distribution(*domain, parts, density, options);
}

/// Checks a rectangle or torus of any size; most are rejected. The parsers of requests already reject negative sides.
void check_sides(bool periodic, double width, double height, const Density& density, const Options& options) {
    const auto domain = periodic ? Domain::torus(width, height) : Domain::rectangle(width, height);
    if (!domain) return check_error(domain.error());
    check_domain(*domain);
    CCDT_CHECK(domain->bounds().width() == width && domain->bounds().height() == height);
    check_distribution(*domain, {}, density, options);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Distributes points in any domain. The input has the options, the density, and the domain: its kind, then its sides,
/// or rings of tagged vertices.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    Bytes input(text_of(data, size));
    const auto options = read_options(input);
    const auto density = read_density(input);
    if (!density) {
        check_error(density.error());
        return 0;
    }
    const auto kind = input.take<std::uint8_t>();
    if (kind % 4U == 3) {
        const double width = std::abs(input.take<double>());
        const double height = std::abs(input.take<double>());
        check_sides(kind % 8U == 3, width, height, *density, options);
    } else {
        check_polygon(read_parts(input), *density, options);
    }
    return 0;
}
