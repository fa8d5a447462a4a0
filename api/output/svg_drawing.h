// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "core/geometry/point.h"

namespace ccdt::api {

enum class Anchor { Start, Middle, End };

/// Builder of an SVG document. Lengths are in user units; y points down. Coordinates are written with two decimals. The
/// same calls give the same bytes.
class SvgDrawing {
public:
    /// Begins a document with a white background.
    SvgDrawing(double width, double height);

    /// @param words  XML text: the caller must have escaped `<` and `&`
    void text(Point at, Anchor anchor, double size, std::string_view words);

    /// @param style  SVG attributes
    void polyline(std::span<const Point> points, std::string_view style);
    void line(Point from, Point to, std::string_view style);
    void rectangle(const Box& box, std::string_view style);

    /// Draws black discs of equal size.
    void dots(std::span<const Point> centres, double radius);

    /// Stretches a picture over a box. Its pixels have sharp edges.
    void picture(const Box& box, std::string_view png);

    /// Clips all shapes to a box until end_clip() is called. Coordinates stay the same.
    void begin_clip(const Box& box);
    void end_clip();

    /// Returns the document. Must be the last call.
    std::string finish();

private:
    void append(std::string_view words) { out_ += words; }
    void append(double length);

    /// Appends strings and lengths, one after the other.
    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

    std::string out_;
};

}  // namespace ccdt::api
