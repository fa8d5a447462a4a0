#pragma once

#include <optional>
#include <string_view>

#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Shape of a dot in drawings made of shapes.
enum class DotStyle {
    Fill,     ///< a disc
    Stroke,   ///< a touch of a pen as wide as the dot: in SVG a stroke of next to no length
    Circles,  ///< concentric circles that fill the dot, for pens finer than it
    Spiral,   ///< a spiral that fills the dot, and a circle along its rim
    Path,     ///< no dots, but one line through their centres in the order of the path
};

/// Options of drawings that every endpoint shares.
struct DrawingOptions {
    std::optional<double> width_mm = {};  ///< of the page; none: only pixels are told
    DotStyle style = DotStyle::Fill;
    double pen_mm = 0.3;  ///< width of the pen, where it is not that of the dots

    /// Tells whether a pen draws, which can only add ink to the paper.
    bool is_stroked() const { return style != DotStyle::Fill; }

    /// Tells whether the pen's own width counts.
    bool has_pen_width() const { return style != DotStyle::Fill && style != DotStyle::Stroke; }
};

/// Names a style as the option has it.
std::string_view name_of(DotStyle style);

/// Reads an option of its member's name. Errors: Malformed.
Result<void> read_width_mm(const Input& input, DrawingOptions& options);
Result<void> read_style(const Input& input, DrawingOptions& options);

/// Reads a width in millimetres, with or without the unit.
Result<void> read_pen(const Input& input, DrawingOptions& options);

}  // namespace ccdt::api
