// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

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

/// Speed of a plotter, and the commands that move its pen.
struct Plotter {
    double speed = 100;                 ///< mm/s, with the pen down or up
    double dwell = 0.075;               ///< seconds for the pen to go down, and as long to go up
    std::string pen_down = "M3 S1000";  ///< G-code; `|` stands between two lines
    std::string pen_up = "M5";
};

/// Options of drawings that every endpoint shares.
struct DrawingOptions {
    std::optional<double> width_mm = {};  ///< of the page; none: only pixels are told
    DotStyle style = DotStyle::Fill;
    double pen_mm = 0.3;  ///< width of the pen, where it is not that of the dots
    Plotter plotter = {};

    /// Tells whether a pen draws, which can only add ink to the paper.
    bool is_stroked() const { return style != DotStyle::Fill; }

    /// Tells whether the pen's own width counts.
    bool has_pen_width() const { return style != DotStyle::Fill && style != DotStyle::Stroke; }

    /// Tells whether a pen fills each dot with turns.
    bool has_turns() const { return style == DotStyle::Circles || style == DotStyle::Spiral; }
};

/// Names a style as the option has it.
std::string_view name_of(DotStyle style);

/// Reads an option of its member's name. Errors: Malformed.
Result<void> read_width_mm(const Input& input, DrawingOptions& options);
Result<void> read_style(const Input& input, DrawingOptions& options);

/// Reads a width in millimetres, with or without the unit.
Result<void> read_pen(const Input& input, DrawingOptions& options);

Result<void> read_speed(const Input& input, DrawingOptions& options);
Result<void> read_dwell(const Input& input, DrawingOptions& options);

/// Read G-code: letters, digits, blanks, points, signs, and `|` between lines. What would end a line, begin a comment
/// or be taken out of the stream by a controller is refused.
Result<void> read_pen_down(const Input& input, DrawingOptions& options);
Result<void> read_pen_up(const Input& input, DrawingOptions& options);

}  // namespace ccdt::api
