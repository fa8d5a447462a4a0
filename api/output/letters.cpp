// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/letters.h"

#include <cairo.h>

#include <memory>
#include <string>

namespace ccdt::api {
namespace {

struct Release {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(cairo_font_options_t* options) const { cairo_font_options_destroy(options); }
    void operator()(cairo_path_t* path) const { cairo_path_destroy(path); }
};

}  // namespace

bool can_letter() {
    return true;
}

std::vector<Ring> letters(std::string_view text, double size) {
    constexpr double kSize = 1'000, kTolerance = 2;  // of the text in which curves become lines
    const std::unique_ptr<cairo_surface_t, Release> surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
    const std::unique_ptr<cairo_t, Release> context(cairo_create(surface.get()));
    const std::unique_ptr<cairo_font_options_t, Release> options(cairo_font_options_create());
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(context.get(), options.get());
    cairo_select_font_face(context.get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context.get(), kSize);
    cairo_set_tolerance(context.get(), kTolerance);
    cairo_text_path(context.get(), std::string(text).c_str());
    const std::unique_ptr<cairo_path_t, Release> path(cairo_copy_path_flat(context.get()));
    std::vector<Ring> rings;
    for (int i = 0; i < path->num_data; i += path->data[i].header.length) {
        const cairo_path_data_type_t type = path->data[i].header.type;
        if (type == CAIRO_PATH_CLOSE_PATH) continue;
        if (type == CAIRO_PATH_MOVE_TO) rings.emplace_back();
        const auto& [x, y] = path->data[i + 1].point;
        rings.back().push_back({x * size / kSize, y * size / kSize});
    }
    std::erase_if(rings, [](const Ring& ring) { return ring.size() < 3; });
    return rings;
}

}  // namespace ccdt::api
