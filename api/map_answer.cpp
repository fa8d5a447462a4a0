// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map_answer.h"

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/image/overlay.h"
#include "api/output/formats.h"
#include "api/output/map_dots.h"
#include "api/run/deadline.h"
#include "api/sample_steps.h"
#include "core/halftone/overprint.h"

namespace ccdt::api {
namespace {

/// Colours of classes. People with any kind of colour vision can distinguish them. The first colours have the most
/// contrast with white. Source: Okabe and Ito.
constexpr std::array<Colour, kMaxInks> kColours = {
    {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}}};

/// Returns the inks of the classes, or a single black ink without a name if answers do not name classes.
Palette palette_of(const SampleRequest& request) {
    if (!request.counts || !request.counts->are_named) return {};
    const FeatureCounts& counts = *request.counts;
    Palette palette{{}, kWhite, Mixing::Multiply};
    for (std::size_t i = 0; i < counts.classes.size(); ++i) palette.inks.push_back({counts.classes[i], kColours[i]});
    return palette;
}

/// Writes a map in a format, with the kind of writer that the format has.
class Writing {
public:
    Writing(const SampleRequest& request, const Page& page, const Report& report, const Palette& palette,
            const MapOfDots& map, Body& body, const Control& control)
        : request_(request),
          page_(page),
          report_(report),
          palette_(palette),
          map_(map),
          body_(body),
          path_stop_(control.stop),
          stop_(stop_of_writing(control, request.on_deadline)) {}

    Result<void> operator()(const ListWriter& writer) const {
        writer.write_map(map_, report_, body_, stop_);
        return {};
    }

    Result<void> operator()(const VectorWriter& writer) const {
        if (auto checked = writer.check(request_, map_.classes.front().radius, page_); !checked) return checked;
        writer.write_map(map_, palette_, page_, request_.drawing, body_, path_stop_, stop_);
        return {};
    }

    Result<void> operator()(const RasterWriter& writer) const {
        std::vector<Raster> rasters;
        for (const MapDots& each : map_.classes)
            rasters.push_back(draw_points(each.dots.dots.points, page_, each.radius, stop_));
        auto picture = writer.write(overlay(std::move(rasters), palette_, true, stop_), page_.width_mm, stop_);
        return std::move(picture).map([&](std::string&& bytes) { body_.text() = std::move(bytes); });
    }

private:
    const SampleRequest& request_;
    const Page& page_;
    const Report& report_;
    const Palette& palette_;
    const MapOfDots& map_;
    Body& body_;
    std::stop_token path_stop_;
    std::stop_token stop_;
};

}  // namespace

Result<void> write_map(const SampleRequest& request, const Domain& whole, const Page& page,
                       std::span<const ClassDots> dots, const Report& report, const Control& control, Body& body) {
    const Palette palette = palette_of(request);
    std::vector<MapDots> classes;
    for (std::size_t i = 0; i < dots.size(); ++i)
        classes.push_back({palette.inks[i], dots[i], radius_of(request, whole)});
    const FeatureList& features = *request.features;
    const bool carries = !features.carried.of_feature.empty();
    const MapOfDots map{classes, features.ids, carries ? &features.carried : nullptr};
    auto written = std::visit(Writing(request, page, report, palette, map, body, control), request.format->writer);
    if (auto going = check_stop(stop_of_writing(control, request.on_deadline)); !going) return going;
    return written;
}

}  // namespace ccdt::api
