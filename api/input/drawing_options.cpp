// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/drawing_options.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr Interval kWidths = {.min = 1, .max = 10'000};
constexpr Interval kPaperSides = {.min = 10, .max = 10'000};
constexpr Interval kResolutions = {.min = 10, .max = 9'600};
constexpr Interval kParts = {.min = 1, .max = 10'000};
constexpr Interval kMargins = {.min = 0, .max = 1'000};
constexpr Interval kPens = {.min = 0.01, .max = 100};
constexpr Interval kSpeeds = {.min = 0.1, .max = 10'000};
constexpr Interval kDwells = {.min = 0, .max = 60};
constexpr std::size_t kLongestCommand = 64;

/// Units of lengths, in millimetres.
constexpr std::array<Choice<double>, 3> kUnits = {{{"mm", 1}, {"cm", 10}, {"in", 25.4}}};

constexpr std::array<Choice<DotStyle>, 5> kStyles = {{{"fill", DotStyle::Fill},
                                                      {"stroke", DotStyle::Stroke},
                                                      {"circles", DotStyle::Circles},
                                                      {"spiral", DotStyle::Spiral},
                                                      {"path", DotStyle::Path}}};

bool is_of_command(char c) {
    constexpr std::string_view kOthers = " .+-|";
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           kOthers.find(c) != std::string_view::npos;
}

Result<std::string> read_command(const Input& input) {
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    if (!text->empty() && text->size() <= kLongestCommand && std::ranges::all_of(*text, is_of_command))
        return std::string(*text);
    return malformed(input, "must be 1 to " + std::to_string(kLongestCommand) +
                                " letters, digits, blanks, points, plus and minus signs, with | between lines");
}

}  // namespace

std::string_view name_of(DotStyle style) {
    return std::ranges::find(kStyles, style, &Choice<DotStyle>::value)->word;
}

Result<double> read_millimetres(const Input& input, const Interval& allowed) {
    const auto text = read_text(input);
    for (const auto& [unit, length] : kUnits) {
        if (!text || !text->ends_with(unit)) continue;
        Input number = input;
        number.value = text->substr(0, text->size() - unit.size());
        const auto value = read_number(number, {allowed.min / length, allowed.max / length, allowed.above_min});
        return value.map([&, factor = length](double each) { return each * factor; });
    }
    return read_number(input, allowed);
}

Result<void> read_width_mm(const Input& input, DrawingOptions& options) {
    return assign(options.width_mm, read_millimetres(input, kWidths));
}

Result<void> read_paper(const Input& input, DrawingOptions& options) {
    // ISO 216, ANSI/ASME Y14.1
    static constexpr std::array<Choice<Point>, 10> kFormats = {{{"a0", {841, 1189}},
                                                                {"a1", {594, 841}},
                                                                {"a2", {420, 594}},
                                                                {"a3", {297, 420}},
                                                                {"a4", {210, 297}},
                                                                {"a5", {148, 210}},
                                                                {"a6", {105, 148}},
                                                                {"letter", {215.9, 279.4}},
                                                                {"legal", {215.9, 355.6}},
                                                                {"tabloid", {279.4, 431.8}}}};
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    const std::string name = in_small_letters(*text);
    const auto known = std::ranges::find(kFormats, name, &Choice<Point>::word);
    if (known != kFormats.end()) {
        options.paper = known->value;
        return {};
    }
    std::string_view rest = name;
    const auto unit = std::ranges::find_if(kUnits, [&](const auto& each) { return rest.ends_with(each.word); });
    const double length = unit == kUnits.end() ? 1 : unit->value;
    if (unit != kUnits.end()) rest.remove_suffix(unit->word.size());
    const auto side = [&](std::string_view digits) {
        const double millimetres = length * parse_number<double>(digits).value_or(0);
        return millimetres >= kPaperSides.min && millimetres <= kPaperSides.max ? millimetres : 0;
    };
    const double width = side(take_until(rest, "x")), height = side(rest);
    options.paper = Point{width, height};
    if (width > 0 && height > 0) return {};
    return malformed(
        input, "must be a0 to a6, letter, legal, tabloid, or two sides from 10 to 10000 mm, such as 300x200 or 9x12in");
}

Result<void> read_margin(const Input& input, DrawingOptions& options) {
    options.of_paper = "margin";
    return assign(options.margin, read_millimetres(input, kMargins));
}

Result<void> read_marks(const Input& input, DrawingOptions& options) {
    options.of_paper = "marks";
    return assign(options.marks, read_boolean(input));
}

Result<void> read_split(const Input& input, DrawingOptions& options) {
    options.is_split = true;
    const auto text = read_text(input);
    if (text && *text == "ink") return {};
    auto read = assign(options.part_minutes, read_number(input, kParts));
    return read ? read : malformed(input, "must be ink, or a number of minutes from 1 to 10000");
}

Result<void> read_dpi(const Input& input, DrawingOptions& options) {
    return assign(options.dpi, read_number(input, kResolutions));
}

Result<void> read_jpeg_quality(const Input& input, DrawingOptions& options) {
    return assign(options.jpeg_quality, read_integer(input, 1, 100));
}

Result<int> width_in_pixels(const DrawingOptions& options) {
    constexpr double kMillimetresPerInch = 25.4, kMaxWidth = 65'535;
    const double width = std::max(std::round(*options.dpi * *options.width_mm / kMillimetresPerInch), 1.0);
    if (width <= kMaxWidth) return static_cast<int>(width);
    return failure(ErrorCode::LimitExceeded, "dpi makes a drawing of more than 65535 pixels in width", "dpi");
}

Result<void> read_style(const Input& input, DrawingOptions& options) {
    return assign(options.style, read_choice<DotStyle>(input, kStyles));
}

Result<void> read_closed(const Input& input, DrawingOptions& options) {
    return assign(options.closed, read_boolean(input));
}

Result<void> check_effects(const DrawingOptions& options, bool has_dot) {
    const auto fault = [](std::string_view option, const std::string& message) {
        return failure(ErrorCode::Malformed, std::string(option) + message, std::string(option));
    };
    const auto needs_width = " " + std::string(kNeedsWidth);
    if (options.closed && options.style != DotStyle::Path) return fault("closed", " is an option of style=path only");
    if (options.has_pen && options.style == DotStyle::Fill)
        return fault("pen", " is an option of style=stroke, circles, spiral and path only");
    if (options.has_pen && options.style == DotStyle::Stroke && !options.has_width()) return fault("pen", needs_width);
    if (options.is_dot() && has_dot) return fault("dot", " is half of pen in this style: give only one of them");
    if (!options.of_paper.empty() && !options.paper)
        return fault(options.of_paper, " needs paper, the format of paper");
    if (options.part_minutes && !options.has_width()) return fault("split", " by minutes" + needs_width);
    if (options.dpi && !options.width_mm)
        return fault("dpi", " needs width_mm, the width of the drawing in millimetres");
    const bool burns_lines = options.plotter.machine == Machine::Laser && options.style == DotStyle::Path;
    if (burns_lines && options.plotter.dwell) return fault("dwell", " has no effect on the lines of a laser");
    if (!options.of_plotter.empty() && !options.has_width()) return fault(options.of_plotter, needs_width);
    return {};
}

Result<void> read_pen(const Input& input, DrawingOptions& options) {
    options.has_pen = true;
    return assign(options.pen_mm, read_millimetres(input, kPens));
}

Result<void> read_speed(const Input& input, DrawingOptions& options) {
    options.of_plotter = "speed";
    return assign(options.plotter.speed, read_number(input, kSpeeds));
}

Result<void> read_dwell(const Input& input, DrawingOptions& options) {
    options.of_plotter = "dwell";
    return assign(options.plotter.dwell, read_number(input, kDwells));
}

Result<void> read_machine(const Input& input, DrawingOptions& options) {
    options.of_plotter = "machine";
    static constexpr std::array<Choice<Machine>, 3> kMachines = {
        {{"grbl", Machine::Grbl}, {"marlin", Machine::Marlin}, {"laser", Machine::Laser}}};
    return assign(options.plotter.machine, read_choice<Machine>(input, kMachines));
}

Result<void> read_dwell_unit(const Input& input, DrawingOptions& options) {
    options.of_plotter = "dwell_unit";
    static constexpr std::array<Choice<bool>, 2> kUnits = {{{"s", false}, {"ms", true}}};
    return assign(options.plotter.dwell_in_ms, read_choice<bool>(input, kUnits));
}

Result<void> read_pen_down(const Input& input, DrawingOptions& options) {
    options.of_plotter = "pen_down";
    return assign(options.plotter.pen_down, read_command(input));
}

Result<void> read_pen_up(const Input& input, DrawingOptions& options) {
    options.of_plotter = "pen_up";
    return assign(options.plotter.pen_up, read_command(input));
}

}  // namespace ccdt::api
