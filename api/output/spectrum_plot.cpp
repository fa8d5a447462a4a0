// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/spectrum_plot.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "api/image/overlay.h"
#include "api/image/png_writer.h"
#include "api/output/svg_drawing.h"
#include "core/base/elementary.h"

namespace ccdt::api {
namespace {

constexpr double kWidth = 1500, kHeight = 540;
constexpr Box kPoints{{40, 50}, {460, 470}};
constexpr Box kSpectrum{{510, 50}, {930, 470}};
constexpr Box kPower{{1010, 50}, {1410, 240}};
constexpr Box kAnisotropy{{1010, 280}, {1410, 470}};

constexpr double kTitle = 16, kLabel = 13, kTick = 12;  // font sizes
constexpr std::string_view kFrame = R"(fill="none" stroke="#000")";
constexpr std::string_view kTickLine = R"(stroke="#000")";
constexpr std::string_view kReference = R"(stroke="#888" stroke-dasharray="5 4")";
constexpr std::string_view kCurve = R"(fill="none" stroke="#1f5fa8" stroke-width="1.5" stroke-linejoin="round")";

constexpr double kMaxShown = 2500;  // maximum number of points that are drawn; more points would look like a grey area
constexpr double kWhitest = 3;      // smallest power that is drawn white, relative to white noise

std::string decimal(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, std::round(value * 1e6) / 1e6 + 0.0).ptr};
}

/// Formats a share as a percentage with one decimal.
std::string percent(double share) {
    return decimal(std::round(1000 * share) / 10);
}

/// Formats an integer with commas between groups of thousands.
std::string grouped(std::size_t number) {
    std::string text = std::to_string(number);
    for (std::size_t end = text.size(); end > 3; end -= 3) text.insert(end - 3, 1, ',');
    return text;
}

double middle(double a, double b) {
    return (a + b) / 2;
}

/// Range of values along one side of a chart.
struct Axis {
    double min;
    double max;
    double step;  ///< distance of ticks

    /// Returns an axis that contains [min, max]. It begins and ends at ticks, and has about five ticks.
    static Axis around(double min, double max) {
        const double raw = (max - min) / 4;
        const double decade = elementary::pow(10, std::floor(elementary::log10(raw)));
        double step = 10 * decade;
        for (const double factor : {5, 2, 1}) {
            if (factor * decade >= raw * (1 - 1e-9)) step = factor * decade;
        }
        return {std::floor(min / step + 1e-9) * step, std::ceil(max / step - 1e-9) * step, step};
    }

    double share(double value) const { return (value - min) / (max - min); }
};

/// Box with axes along its left and lower sides.
struct Chart {
    Box box;
    Axis x;
    Axis y;

    Point at(double horizontal, double vertical) const {
        return {box.min.x + x.share(horizontal) * box.width(), box.max.y - y.share(vertical) * box.height()};
    }
};

template <class Draw>
void for_each_tick(const Axis& axis, Draw draw) {
    const auto first = static_cast<long>(std::ceil(axis.min / axis.step - 1e-9));
    const auto last = static_cast<long>(std::floor(axis.max / axis.step + 1e-9));
    for (long tick = first; tick <= last; ++tick) draw(static_cast<double>(tick) * axis.step);
}

void draw_ticks_below(SvgDrawing& svg, const Chart& chart, bool labels) {
    for_each_tick(chart.x, [&](double value) {
        const Point at = chart.at(value, chart.y.min);
        svg.line(at, at + Point{0, 5}, kTickLine);
        if (labels) svg.text(at + Point{0, 19}, Anchor::Middle, kTick, decimal(value));
    });
}

void draw_ticks_at_left(SvgDrawing& svg, const Chart& chart) {
    for_each_tick(chart.y, [&](double value) {
        const Point at = chart.at(chart.x.min, value);
        svg.line(at - Point{5, 0}, at, kTickLine);
        svg.text(at + Point{-9, 4}, Anchor::End, kTick, decimal(value));
    });
}

void draw_title(SvgDrawing& svg, const Box& box, std::string_view words) {
    svg.text({middle(box.min.x, box.max.x), box.min.y - 14}, Anchor::Middle, kTitle, words);
}

void draw_caption(SvgDrawing& svg, const Box& box, double distance, std::string_view words) {
    svg.text({middle(box.min.x, box.max.x), box.max.y + distance}, Anchor::Middle, kLabel, words);
}

void draw_curve(SvgDrawing& svg, const Chart& chart, const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < x.size(); ++i) points.push_back(chart.at(x[i], y[i]));
    svg.begin_clip(chart.box);
    svg.polyline(points, kCurve);
    svg.end_clip();
}

/// Draws a horizontal line, with a label, for comparison with the curve.
void draw_reference(SvgDrawing& svg, const Chart& chart, double level, std::string_view words) {
    const Point end = chart.at(chart.x.max, level);
    svg.line(chart.at(chart.x.min, level), end, kReference);
    svg.text(end + Point{7, 4}, Anchor::Start, kTick, words);
}

/// Part of the domain that is shown, and its scale.
struct View {
    Box shown;
    Point centre;  ///< centre of the panel
    double scale;

    bool holds(Point p) const {
        return p.x >= shown.min.x && p.x <= shown.max.x && p.y >= shown.min.y && p.y <= shown.max.y;
    }
    Point position(Point p) const {
        return {centre.x + scale * (p.x - middle(shown.min.x, shown.max.x)),
                centre.y - scale * (p.y - middle(shown.min.y, shown.max.y))};
    }
};

/// Selects the whole domain, or a part in its middle that would contain a share of the points if they were spread
/// evenly.
View view_of(double share, Point sides, const Box& panel) {
    const double side = std::sqrt(share * sides.x) * std::sqrt(sides.y);
    const auto half = [&](double length) { return (share < 1 ? std::min(length, side) : length) / 2; };
    const Point centre = 0.5 * sides, reach{half(sides.x), half(sides.y)};
    return {{centre - reach, centre + reach},
            {middle(panel.min.x, panel.max.x), middle(panel.min.y, panel.max.y)},
            std::min(panel.width() / 2 / reach.x, panel.height() / 2 / reach.y)};
}

/// Draws points in a panel.
/// @param most   maximum number of points that are drawn
/// @param words  returns the caption from the number of points that are drawn
template <class Words>
void draw_points(SvgDrawing& svg, std::span<const Point> points, Point sides, double unit, const Box& panel,
                 double most, Words&& words) {
    const View view = view_of(std::min(1.0, most / std::max(1.0, static_cast<double>(points.size()))), sides, panel);
    std::vector<Point> dots;
    for (const Point& p : points) {
        if (view.holds(p)) dots.push_back(view.position(p));
    }
    const Point low = view.position(view.shown.min), high = view.position(view.shown.max);
    const Box frame{{low.x, high.y}, {high.x, low.y}};
    svg.begin_clip(frame);
    svg.dots(dots, std::clamp(0.18 * view.scale / unit, 0.8, 5.0));
    svg.end_clip();
    svg.rectangle(frame, kFrame);
    words(frame, dots.size());
}

std::string caption_of(const Analysis& analysis) {
    return grouped(analysis.points) + " points" +
           (analysis.sets > 1 ? ", first of " + grouped(analysis.sets) + " sets" : "");
}

void draw_panels(SvgDrawing& svg, const Analysis& analysis, std::span<const Point> points, Point sides) {
    draw_title(svg, kPoints, "Points");
    draw_points(svg, points, sides, analysis.unit, kPoints, kMaxShown, [&](const Box& frame, std::size_t shown) {
        const std::string part = shown < points.size() ? "the middle: " + grouped(shown) + " of " : "";
        draw_caption(svg, frame, 22, part + caption_of(analysis));
    });
}

/// Draws four slabs in the middle, each as thick as the mean spacing.
void draw_panels(SvgDrawing& svg, const Analysis& analysis, std::span<const Point3> points, Point3 sides) {
    constexpr int kSlabs = 4;
    constexpr Point kPanel{195, 190}, kStep{225, 220};
    draw_title(svg, kPoints, "Points in four slabs next to each other");
    const double thickness = std::min(1 / (analysis.unit * sides.z), 1.0 / kSlabs);  // relative to the depth
    for (int slab = 0; slab < kSlabs; ++slab) {
        const double low = 0.5 + (slab - kSlabs / 2) * thickness, high = low + thickness;
        std::vector<Point> inside;
        for (const Point3& p : points) {
            if (p.z >= low * sides.z && p.z < high * sides.z) inside.push_back({p.x, p.y});
        }
        const Point corner = kPoints.min + Point{slab % 2 * kStep.x, slab / 2 * kStep.y};
        draw_points(svg, inside, {sides.x, sides.y}, analysis.unit, {corner, corner + kPanel}, kMaxShown / kSlabs,
                    [&](const Box& frame, std::size_t) {
                        draw_caption(svg, frame, 16, percent(low) + " to " + percent(high) + " % of the depth");
                    });
    }
    draw_caption(svg, kPoints, 44, caption_of(analysis));
}

/// The spectrum as a grey picture, with light in proportion to power; y points down.
struct Periodogram {
    Raster raster;
    Point size;  ///< size in frequencies; may extend beyond the spectrum
};

/// Returns the mean power of the frequencies that one pixel shows.
/// @param column, row  of the pixel
/// @param shrink       frequencies per pixel along each axis
double block_mean(const Spectrum& spectrum, int column, int row, int shrink) {
    double sum = 0, count = 0;
    for (int r = row * shrink; r < std::min((row + 1) * shrink, spectrum.height); ++r) {
        for (int c = column * shrink; c < std::min((column + 1) * shrink, spectrum.width); ++c) {
            sum += spectrum.at(c - spectrum.width / 2, spectrum.height / 2 - r);
            ++count;
        }
    }
    return sum / count;
}

/// Draws the spectrum. If the spectrum is large, each pixel shows the mean of several frequencies. If the spectrum is
/// small, each frequency has several pixels, because some viewers blur pictures when they enlarge them.
Periodogram draw_periodogram(const Spectrum& spectrum) {
    constexpr int kMaxPixels = 640, kMinPixels = 480;
    const int side = std::max(spectrum.width, spectrum.height);
    const int shrink = (side + kMaxPixels - 1) / kMaxPixels;
    const int repeat = (kMinPixels + side - 1) / side;
    const int columns = (spectrum.width + shrink - 1) / shrink, rows = (spectrum.height + shrink - 1) / shrink;
    Periodogram result{{columns * repeat, rows * repeat, 0, {}}, {double(columns) * shrink, double(rows) * shrink}};
    std::vector<std::uint8_t>& pixels = result.raster.coverage;
    for (int row = 0; row < rows; ++row) {
        std::vector<std::uint8_t> line;
        for (int column = 0; column < columns; ++column) {
            const double light = std::min(block_mean(spectrum, column, row, shrink) / kWhitest, 1.0);
            line.insert(line.end(), static_cast<std::size_t>(repeat),
                        static_cast<std::uint8_t>(std::lround(255 * light)));
        }
        for (int i = 0; i < repeat; ++i) pixels.insert(pixels.end(), line.begin(), line.end());
    }
    return result;
}

/// @param title  title of the spectrum
Result<void> draw_spectrum(SvgDrawing& svg, const Analysis& analysis, Point sides, double max_frequency,
                           std::string_view title) {
    const Periodogram periodogram = draw_periodogram(analysis.spectrum);
    const auto png = write_png(overlay({periodogram.raster}, {{{"", kWhite}}, kBlack}, true));
    if (!png) return tl::unexpected(png.error());

    const Axis axis{-max_frequency, max_frequency, std::ceil(max_frequency / 4)};
    const Chart chart{kSpectrum, axis, axis};
    const Point step{1 / (sides.x * analysis.unit), 1 / (sides.y * analysis.unit)};
    const Point low{-0.5 * analysis.spectrum.width * step.x, 0.5 * analysis.spectrum.height * step.y};
    const Point high = low + Point{periodogram.size.x * step.x, -periodogram.size.y * step.y};
    svg.begin_clip(kSpectrum);
    svg.picture({chart.at(low.x, low.y), chart.at(high.x, high.y)}, *png);
    svg.end_clip();
    svg.rectangle(kSpectrum, kFrame);
    draw_ticks_below(svg, chart, true);
    draw_ticks_at_left(svg, chart);
    draw_title(svg, kSpectrum, title);
    draw_caption(svg, kSpectrum, 44, "black: no power; white: " + decimal(kWhitest) + " times white noise or more");
    return {};
}

void draw_power(SvgDrawing& svg, const Analysis& analysis, const Axis& frequencies) {
    const double highest = *std::ranges::max_element(analysis.power);
    const Chart chart{kPower, frequencies, Axis::around(0, std::max(highest, 1.5))};
    draw_title(svg, kPower, "Radially averaged power");
    draw_reference(svg, chart, 1, "white noise");
    draw_curve(svg, chart, analysis.frequency, analysis.power);
    svg.rectangle(kPower, kFrame);
    draw_ticks_below(svg, chart, false);
    draw_ticks_at_left(svg, chart);
}

void draw_anisotropy(SvgDrawing& svg, const Analysis& analysis, const Axis& frequencies, std::string_view unit) {
    constexpr double kMax = 40;  // dB; values farther from isotropy belong to rings with almost no power
    const double isotropic = -10 * elementary::log10(static_cast<double>(analysis.sets));
    const auto [low, high] = std::ranges::minmax(analysis.anisotropy_db);
    const double least = std::max(std::min(low, isotropic - 5), isotropic - kMax);
    const double most = std::min(std::max(high, isotropic + 5), isotropic + kMax);
    const Chart chart{kAnisotropy, frequencies, Axis::around(least, most)};
    draw_title(svg, kAnisotropy, "Anisotropy, dB");
    draw_reference(svg, chart, isotropic, "isotropic");
    draw_curve(svg, chart, analysis.frequency, analysis.anisotropy_db);
    svg.rectangle(kAnisotropy, kFrame);
    draw_ticks_below(svg, chart, true);
    draw_ticks_at_left(svg, chart);
    draw_caption(svg, kAnisotropy, 44, "frequency, in units of " + std::string(unit));
}

template <class P>
Result<std::string> plot(const Analysis& analysis, std::span<const P> points, P sides, double max_frequency,
                         std::string_view title, std::string_view unit) {
    SvgDrawing svg(kWidth, kHeight);
    draw_panels(svg, analysis, points, sides);
    if (auto drawn = draw_spectrum(svg, analysis, {sides.x, sides.y}, max_frequency, title); !drawn) {
        return tl::unexpected(drawn.error());
    }
    const Axis frequencies{0, max_frequency, std::ceil(max_frequency / 8)};
    draw_power(svg, analysis, frequencies);
    draw_anisotropy(svg, analysis, frequencies, unit);
    return svg.finish();
}

}  // namespace

Result<std::string> plot_spectrum(const Analysis& analysis, std::span<const Point> points, Point sides,
                                  double max_frequency) {
    return plot(analysis, points, sides, max_frequency, "Power spectrum", "&#8730;(points / area)");
}

Result<std::string> plot_spectrum(const Analysis& analysis, std::span<const Point3> points, Point3 sides,
                                  double max_frequency) {
    return plot(analysis, points, sides, max_frequency, "Slice of the power spectrum", "&#8731;(points / volume)");
}

}  // namespace ccdt::api
