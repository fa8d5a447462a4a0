// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/svg_renderer.h"

#include <librsvg/rsvg.h>

#include <cmath>
#include <exception>
#include <memory>

namespace ccdt::api {
namespace {

struct Unref {
    void operator()(RsvgHandle* handle) const { g_object_unref(handle); }
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
};

using Handle = std::unique_ptr<RsvgHandle, Unref>;
using Surface = std::unique_ptr<cairo_surface_t, Unref>;
using Context = std::unique_ptr<cairo_t, Unref>;

cairo_status_t append(void* bytes, const unsigned char* data, unsigned size) {
    try {
        static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), size);
    } catch (const std::exception&) {
        return CAIRO_STATUS_NO_MEMORY;
    }
    return CAIRO_STATUS_SUCCESS;
}

Handle load(std::string_view svg) {
    return Handle(rsvg_handle_new_from_data(reinterpret_cast<const guint8*>(svg.data()), svg.size(), nullptr));
}

/// @returns  null on an error
Surface draw(RsvgHandle* handle, double scale) {
    double width = 0, height = 0;
    if (!rsvg_handle_get_intrinsic_size_in_pixels(handle, &width, &height)) return nullptr;
    const RsvgRectangle viewport{0, 0, std::ceil(width * scale), std::ceil(height * scale)};
    Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(viewport.width),
                                               static_cast<int>(viewport.height)));
    const Context context(cairo_create(surface.get()));
    const bool drawn = rsvg_handle_render_document(handle, context.get(), &viewport, nullptr) != 0;
    if (!drawn || cairo_status(context.get()) != CAIRO_STATUS_SUCCESS) return nullptr;
    return surface;
}

}  // namespace

Result<std::string> render_svg(std::string_view svg, double scale) {
    const Handle handle = load(svg);
    const Surface surface = handle ? draw(handle.get(), scale) : nullptr;
    std::string png;
    if (!surface || cairo_surface_write_to_png_stream(surface.get(), append, &png) != CAIRO_STATUS_SUCCESS) {
        return failure(ErrorCode::Internal, "the plot could not be drawn");
    }
    return png;
}

}  // namespace ccdt::api
