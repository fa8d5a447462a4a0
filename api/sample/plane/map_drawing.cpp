// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/map_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "api/text/numbers.h"
#include "core/ccdt/globe/region.h"
#include "core/halftone/inks/overprint.h"

namespace ccdt::api {
namespace {

/// Colours of classes. People with any kind of colour vision can distinguish them. The first colours have the most
/// contrast with white. Source: Okabe and Ito.
constexpr std::array<Colour, kMaxInks> kColours = {
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}}};

/// Parts of a drawing besides points.
struct MapStyle {
    bool is_map = false, outlines = false, legend = false;
};

MapStyle map_style(const SampleRequest& request, const PointFormat& format) {
    const SampleOutput& output = request.output;
    if (!can_draw_maps(format, output.drawing)) return {};
    const bool is_usual = request.region.is_on_globe() && request.counts;
    const bool outlines = output.outlines.value_or(is_usual);
    const bool legend = output.legend.value_or(is_usual) && request.counts;
    return {is_usual || outlines || legend, outlines, legend};
}

using Features = std::vector<std::vector<PolygonPart>>;

/// Returns the polygons of each feature as they were given, or of the whole domain. Leaves out invalid features.
Features features_of(const SampleRequest& request) {
    if (const auto* rectangle = std::get_if<Rectangle>(&request.region.domain)) {
        const double width = rectangle->width, height = rectangle->height;
        return {{{{{0, 0}, {width, 0}, {width, height}, {0, height}}, {}}}};
    }
    Features features;
    for (std::size_t i = 0; request.features && i < request.features->size(); ++i) {
        if (auto parts = parts_of(request, i)) features.push_back(*std::move(parts));
    }
    if (!features.empty()) return features;
    const auto& given = std::get<PolygonInput>(request.region.domain).parts;
    auto parts = request.region.is_on_globe() ? unrolled(given) : Result<std::vector<PolygonPart>>(given);
    if (parts) features.push_back(*std::move(parts));
    return features;
}

/// Traces the borders of all features, including those that other features share.
void trace_all(const Features& features, const MapProjection* projection, const LineSink& sink) {
    for (const auto& feature : features) Outlines(projection, 0).trace(feature, sink);
}

Box bounds_of(const Features& features, const MapProjection& projection) {
    constexpr double kFar = std::numeric_limits<double>::max();
    Box box{{kFar, kFar}, {-kFar, -kFar}};
    trace_all(features, &projection, [&](Point corner, bool) { box.include(corner); });
    return box;
}

/// Returns SampleDrawing::pitch of a dot map.
double dense_pitch(const SampleArea& area, bool on_globe) {
    constexpr double kShare = 0.1;                    // of the dots that are in denser features
    std::vector<std::pair<double, double>> features;  // pitch, dots
    double all = 0;
    for (const MapFeature& feature : area.features) {
        double dots = 0;
        for (const std::size_t count : feature.dots) dots += static_cast<double>(count);
        if (dots == 0) continue;
        features.emplace_back(std::sqrt((on_globe ? ground_area(feature.area) : feature.area.area()) / dots), dots);
        all += dots;
    }
    std::ranges::sort(features);
    double denser = 0;
    for (const auto& [pitch, dots] : features) {
        denser += dots;
        if (denser >= kShare * all) return pitch;
    }
    return features.back().first;
}

double pitch_of(const SampleRequest& request, const SampleArea& area, const Box& box, bool is_map) {
    constexpr double kLeast = 1e-3;
    const bool on_globe = request.region.is_on_globe();
    if (request.counts && (on_globe || is_map))
        return std::max(dense_pitch(area, on_globe), kLeast * std::max(box.width(), box.height()));
    const double ground = on_globe ? ground_area(area.whole) : area.whole.area();
    return std::sqrt(ground / static_cast<double>(request.run.sites));
}

std::vector<LegendEntry> legend_of(const SampleRequest& request) {
    const FeatureCounts& counts = *request.counts;
    std::vector<LegendEntry> entries;
    if (counts.are_named) {
        for (const Ink& ink : palette_of(request).inks) entries.push_back({ink.colour, ink.name, {}});
    }
    std::string unit = "1 dot = ";
    append_shortest(unit, counts.per);
    if (!counts.are_named) unit += ' ' + counts.classes.front();
    entries.push_back({std::nullopt, std::move(unit), {}});
    return entries;
}

/// Estimates the width of an entry, in sizes of its text.
double width_of(const LegendEntry& entry) {
    constexpr double kLetter = 0.65, kIdeograph = 1;
    double width = entry.colour ? kLegendIndent : 0;
    for (const char c : entry.text) {
        const auto byte = static_cast<unsigned char>(c);
        width += byte < 0x80 ? kLetter : byte >= 0xc0 ? kIdeograph : 0;
    }
    return width;
}

/// Returns the first of some boxes that lies outside all features; none if there is no such box.
std::optional<Box> find_free(std::span<const Box> boxes, const Features& features, const MapProjection* projection) {
    std::vector<bool> touched(boxes.size()), inside(boxes.size());
    Point before;
    trace_all(features, projection, [&](Point corner, bool begins) {
        for (std::size_t i = 0; !begins && i < boxes.size(); ++i) {
            const auto& [min, max] = boxes[i];
            const auto [west, east] = std::minmax(before.x, corner.x);
            const auto [south, north] = std::minmax(before.y, corner.y);
            if (west <= max.x && east >= min.x && south <= max.y && north >= min.y) touched[i] = true;
            // Whether the ray from the corner `min` to the west crosses the edge.
            if ((before.y > min.y) != (corner.y > min.y) &&
                before.x + (min.y - before.y) / (corner.y - before.y) * (corner.x - before.x) < min.x)
                inside[i] = !inside[i];
        }
        before = corner;
    });
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (!touched[i] && !inside[i]) return boxes[i];
    }
    return std::nullopt;
}

/// Places a legend, and makes the box of the drawing larger if no corner of it is free.
void place_legend(std::vector<LegendEntry> entries, const Features& features, const MapProjection* projection,
                  MapFigure& figure, Box& box) {
    constexpr double kSize = 0.022, kMostOfWidth = 0.85, kLine = 1.4, kDescent = 0.35, kInset = 0.5;
    double width = 0;
    for (const LegendEntry& entry : entries) width = std::max(width, width_of(entry));
    const double size = std::min(kSize * std::max(box.width(), box.height()), kMostOfWidth * box.width() / width);
    const Point sides{width * size, kLine * size * static_cast<double>(entries.size())};
    const double gap = kInset * size;
    const double west = box.min.x + gap, east = box.max.x - gap - sides.x;
    const double south = box.min.y + gap, north = box.max.y - gap - sides.y;
    std::vector<Box> corners;
    for (const Point corner : {Point{west, south}, Point{east, south}, Point{east, north}, Point{west, north}})
        corners.push_back({corner, corner + sides});
    std::optional<Box> area = find_free(corners, features, projection);
    if (!area) {
        box.min.y -= sides.y + 2 * gap;
        const Point corner{west, box.min.y + gap};
        area = Box{corner, corner + sides};
    }
    for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i].at = {area->min.x, area->max.y - size * (kLine * static_cast<double>(i + 1) - kDescent)};
    figure.text_size = size;
    figure.legend = std::move(entries);
}

}  // namespace

Palette palette_of(const SampleRequest& request) {
    if (!request.counts || !request.counts->are_named) return {};
    const FeatureCounts& counts = *request.counts;
    Palette palette{{}, kWhite, Mixing::Multiply};
    for (std::size_t i = 0; i < counts.classes.size(); ++i) palette.inks.push_back({counts.classes[i], kColours[i]});
    return palette;
}

bool can_draw_maps(const PointFormat& format, const DrawingOptions& drawing) {
    const VectorWriter* const shapes = format.vector();
    return format.is_drawn() && (shapes == nullptr || !shapes->by_pen) && !drawing.is_stroked() && !drawing.is_split;
}

std::vector<Point> SampleDrawing::place(std::vector<Point> points) const {
    if (projection) std::ranges::transform(points, points.begin(), *projection);
    return points;
}

SampleDrawing plan_drawing(const SampleRequest& request, const PointFormat& format, const SampleArea& area) {
    constexpr double kMargin = 0.005, kLineWidth = 0.0006, kTolerance = 0.00025;  // of the longer side
    constexpr double kLineShare = 0.03;                                           // of the mean side of a feature
    const auto [is_map, has_outlines, has_legend] = map_style(request, format);
    const bool on_globe = request.region.is_on_globe() && format.is_drawn();
    SampleDrawing drawing{{}, area.whole.bounds(), 0, {}};
    auto features = std::make_shared<Features>();
    if (on_globe || is_map) *features = features_of(request);
    if (on_globe) {
        std::vector<PolygonPart> all;
        for (const auto& feature : *features) all.insert(all.end(), feature.begin(), feature.end());
        drawing.projection = MapProjection::fitting(all);
        drawing.box = bounds_of(*features, *drawing.projection);
    }
    drawing.pitch = pitch_of(request, area, drawing.box, is_map);
    if (!is_map) return drawing;
    Box& box = drawing.box;
    const double longer = std::max(box.width(), box.height());
    const Point margin{kMargin * longer, kMargin * longer};
    box = {box.min - margin, box.max + margin};
    // Outlines of many small features would hide the dots, so they are thinner.
    const double area_of_map = on_globe ? ground_area(area.whole) : area.whole.area();
    const double side = std::sqrt(area_of_map / static_cast<double>(features->size()));
    MapFigure figure{{}, std::min(kLineWidth * longer, kLineShare * side), {}, 0};
    if (has_legend)
        place_legend(legend_of(request), *features, drawing.projection ? &*drawing.projection : nullptr, figure, box);
    if (has_outlines) {
        figure.outlines = [features, projection = drawing.projection, longer](const LineSink& sink) {
            Outlines outlines(projection ? &*projection : nullptr, kTolerance * longer);
            for (const auto& feature : *features) outlines.trace(feature, sink);
        };
    }
    drawing.figure = std::move(figure);
    return drawing;
}

}  // namespace ccdt::api
