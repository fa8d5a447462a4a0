// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// Shape of a dot in drawings made of shapes.
enum class DotStyle {
    Fill,     ///< a disc
    Stroke,   ///< a touch of a pen that is as wide as the dot; in SVG, a stroke of almost no length
    Circles,  ///< concentric circles that fill the dot, for a pen that is finer than the dot
    Spiral,   ///< a spiral that fills the dot, and a circle along its rim
    Path,     ///< no dots, but a line through their centres in the order of a short path
};

/// Kind of a machine that reads G-code.
enum class Machine {
    Grbl,    ///< GRBL, LinuxCNC and others
    Marlin,  ///< dwells are in milliseconds; the feed rate also holds for G0; there is no command that ends a program
    Laser,   ///< GRBL with a laser instead of a pen, which is off in all moves between strokes
};

/// Speed of a plotter, and the commands that move its pen or switch its laser.
struct Plotter {
    double speed = 100;                      ///< mm/s, the same with the pen down and up
    std::optional<double> dwell = {};        ///< seconds for lowering the pen, and the same for raising it; none: 0.075
    std::optional<bool> dwell_in_ms = {};    ///< whether G-code states the dwell in milliseconds instead of seconds
    std::string pen_down = {}, pen_up = {};  ///< G-code; `|` separates lines; empty: as usual for the machine
    Machine machine = Machine::Grbl;

    /// Returns the pause of the pen before and after a stroke. A laser only pauses to burn a dot.
    double pause() const { return dwell.value_or(0.075); }

    /// Returns the duration of all pauses for a stroke.
    /// @param is_dot  whether the stroke only touches the paper
    double pauses(bool is_dot) const { return machine != Machine::Laser ? 2 * pause() : is_dot ? pause() : 0; }
};

/// Options of drawings that /halftone and /sample share.
struct DrawingOptions {
    /// Width of the drawing on paper; none: it follows from `paper`, or the size is in pixels only.
    std::optional<double> width_mm = {};
    std::optional<Point> paper = {};  ///< sides of the paper in millimetres, which is turned to suit the drawing
    double margin = 10;               ///< smallest distance of the drawing from the edges of the paper, mm
    bool marks = false;               ///< whether registration marks are drawn around the drawing, by each pen
    std::string_view of_paper = {};   ///< name of an option of `paper` that is given; empty: none
    DotStyle style = DotStyle::Fill;
    double pen_mm = 0.3;                      ///< width of the pen; not used by Fill
    bool is_split = false;                    ///< whether each ink has a file of its own
    std::optional<double> part_minutes = {};  ///< maximum drawing time of a file; requires `is_split`
    std::optional<double> dpi = {};           ///< pixels per inch of a drawing of pixels
    std::optional<int> jpeg_quality = {};     ///< 1 to 100, the scale of libjpeg
    bool has_pen = false;      ///< whether the width of the pen is given; it is then the width of the dots of Stroke
    bool closed = false;       ///< whether the line of the style Path ends where it starts
    bool pen_follows = false;  ///< whether the pen is as wide as the picture needs, in the style Path
    Plotter plotter = {};
    std::string_view of_plotter = {};  ///< name of an option of `plotter` that is given; empty: none

    /// Whether the drawing has a width in millimetres.
    bool has_width() const { return width_mm || paper; }

    /// Whether the drawing is made of pen strokes, which can only add ink to the paper.
    bool is_stroked() const { return style != DotStyle::Fill; }

    /// Whether the drawing depends on `pen_mm`.
    bool has_pen_width() const { return style == DotStyle::Stroke ? has_pen : style != DotStyle::Fill && !pen_follows; }

    /// Whether the given pen is as wide as what it draws, so that it replaces the radius of dots.
    bool is_dot() const { return has_pen && (style == DotStyle::Stroke || style == DotStyle::Path); }

    /// Whether a pen fills each dot with circles or with the turns of a spiral.
    bool has_turns() const { return style == DotStyle::Circles || style == DotStyle::Spiral; }
};

/// End of messages about options that need DrawingOptions::has_width().
inline constexpr std::string_view kNeedsWidth = "needs width_mm or paper, which give the drawing a size in millimetres";

/// Returns the name of a style, as the option `style` gives it.
std::string_view name_of(DotStyle style);

/// Reads a length in millimetres. As text, it may end with the unit mm, cm or in. Errors: Malformed.
Result<double> read_millimetres(const Input& input, const Interval& allowed);

/// Reads the option after which the function is named. Errors: Malformed.
Result<void> read_width_mm(const Input& input, DrawingOptions& options);

/// Reads the name of a format of paper, or its sides such as `300x200`, in millimetres, or `9x12in`. Errors: Malformed.
Result<void> read_paper(const Input& input, DrawingOptions& options);
Result<void> read_margin(const Input& input, DrawingOptions& options);
Result<void> read_marks(const Input& input, DrawingOptions& options);
Result<void> read_split(const Input& input, DrawingOptions& options);
Result<void> read_dpi(const Input& input, DrawingOptions& options);
Result<void> read_jpeg_quality(const Input& input, DrawingOptions& options);
Result<void> read_style(const Input& input, DrawingOptions& options);
Result<void> read_closed(const Input& input, DrawingOptions& options);
Result<void> read_pen(const Input& input, DrawingOptions& options);

/// Returns the width in pixels of a drawing of which width_mm and dpi are given.
/// Errors: LimitExceeded; Error::field is the name of an option.
Result<int> width_in_pixels(const DrawingOptions& options);

/// Checks that all options of pens and plotters that are given have an effect.
/// @param has_dot  whether the radius of dots is given
/// Errors: Malformed; Error::field is the name of the first option without effect.
Result<void> check_effects(const DrawingOptions& options, bool has_dot);

Result<void> read_speed(const Input& input, DrawingOptions& options);
Result<void> read_dwell(const Input& input, DrawingOptions& options);
Result<void> read_machine(const Input& input, DrawingOptions& options);
Result<void> read_dwell_unit(const Input& input, DrawingOptions& options);

/// Reads a command in G-code: letters, digits, blanks, points, signs, and `|` between lines. Rejects all other
/// characters, such as those that end a line, begin a comment, or are removed from the stream by a controller.
Result<void> read_pen_down(const Input& input, DrawingOptions& options);
Result<void> read_pen_up(const Input& input, DrawingOptions& options);

/// Reads an option of drawings into a target.
/// @tparam drawing_of  returns the options of drawings that the target has
template <class Target, DrawingOptions& (*drawing_of)(Target&), Result<void> (*read)(const Input&, DrawingOptions&)>
Result<void> drawing_rule(const Input& input, const Limits&, Target& target) {
    return read(input, drawing_of(target));
}

/// Returns the rules of all options of drawings.
template <class Target, DrawingOptions& (*drawing_of)(Target&)>
constexpr auto drawing_rules() {
    return std::to_array<OptionRule<Target>>({
        {"width_mm", drawing_rule<Target, drawing_of, read_width_mm>},
        {"paper", drawing_rule<Target, drawing_of, read_paper>},
        {"margin", drawing_rule<Target, drawing_of, read_margin>},
        {"marks", drawing_rule<Target, drawing_of, read_marks>},
        {"split", drawing_rule<Target, drawing_of, read_split>},
        {"dpi", drawing_rule<Target, drawing_of, read_dpi>},
        {"jpeg_quality", drawing_rule<Target, drawing_of, read_jpeg_quality>},
        {"style", drawing_rule<Target, drawing_of, read_style>},
        {"closed", drawing_rule<Target, drawing_of, read_closed>},
        {"pen", drawing_rule<Target, drawing_of, read_pen>},
        {"speed", drawing_rule<Target, drawing_of, read_speed>},
        {"dwell", drawing_rule<Target, drawing_of, read_dwell>},
        {"machine", drawing_rule<Target, drawing_of, read_machine>},
        {"dwell_unit", drawing_rule<Target, drawing_of, read_dwell_unit>},
        {"pen_down", drawing_rule<Target, drawing_of, read_pen_down>},
        {"pen_up", drawing_rule<Target, drawing_of, read_pen_up>},
    });
}

}  // namespace ccdt::api
