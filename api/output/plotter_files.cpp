// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/plotter_files.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

/// Base class of the writers. Appends text, and converts points to coordinates with the y axis pointing up.
class PlotterFile {
public:
    PlotterFile(const Plot& plot, Body& body, const std::stop_token& stop)
        : body_(body), stop_(stop), size_(plot.page.size()) {}

    bool should_continue() { return body_.flush() && !stop_.stop_requested(); }

protected:
    Point upright(Point p) const { return {p.x, size_.y - p.y}; }
    Point size() const { return size_; }

    template <class... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
    }

private:
    void append(std::string_view words) { body_.text() += words; }

    /// Appends a length in millimetres with four decimals. Machines have a resolution of about 0.01 mm.
    void append(double length) { append_fixed(body_.text(), length, 4); }

    void append(long long whole) { body_.text() += std::to_string(whole); }

    Body& body_;
    const std::stop_token& stop_;
    Point size_;
};

template <class Medium>
void trace(const Plot& plot, const Pen& pen, Medium& medium) {
    trace_marks(plot.page, medium);
    for (const PenRun& run : pen.runs) trace(plot, pen, run, medium);
}

/// Converts a label to upper-case ASCII letters, with underscores for all other bytes. Digits and punctuation may have
/// a meaning in the languages of machines.
std::string plain(std::string_view label) {
    constexpr std::size_t kMaxLength = 24;
    std::string text(label.substr(0, kMaxLength));
    for (char& c : text) {
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
        if (c < 'A' || c > 'Z') c = '_';
    }
    return text;
}

// There are no comments, because Inkscape refuses files with the instruction CO.
class Hpgl : public PlotterFile {
public:
    using PlotterFile::PlotterFile;

    void initialise() { write("IN;PA;\n"); }
    void select(std::size_t number) { write("SP", static_cast<long long>(number), ";\n"); }
    void finish() { write("PU;SP0;\n"); }

    void begin(Point at) {
        write("PU");
        write_units(at);
        write(";PD");
        is_touch_ = true;
    }

    void line_to(Point at) {
        if (!is_touch_) write(",");
        write_units(at);
        is_touch_ = false;
    }

    void end() { write(";\n"); }

private:
    void write_units(Point at) {
        constexpr double kUnits = 40;  // per millimetre
        const Point p = upright(at);
        write(std::llround(kUnits * p.x), ",", std::llround(kUnits * p.y));
    }

    bool is_touch_ = false;
};

class Gcode : public PlotterFile {
public:
    Gcode(const Plot& plot, Body& body, const std::stop_token& stop)
        : PlotterFile(plot, body, stop),
          machine_(plot.plotter.machine),
          feed_(60 * plot.plotter.speed),
          down_(commands(plot.plotter.pen_down, kDown[index()])),
          up_(commands(plot.plotter.pen_up, kUp[index()])),
          dot_(down_),
          commands_set_feed_((down_ + up_).find_first_of("Ff") != std::string::npos) {
        const std::string pause = pause_of(plot.plotter);
        if (machine_ != Machine::Laser) {
            for (std::string* const each : {&down_, &up_, &dot_}) *each += pause;
            return;
        }
        // With M4, the power follows the speed, so a laser at rest needs M3. It is on only in the mode G1.
        dot_ = "G1 F";
        append_fixed(dot_, feed_, 4);
        dot_ += '\n' + commands(plot.plotter.pen_down, "M3 S1000") + pause;
    }

    void initialise(const Plot& plot) { write("; ", plot.description(), "\nG21\nG90\n", up_); }

    void select(std::size_t number, std::string_view label) {
        if (number > 1) write("M0\n");
        write("; PEN ", static_cast<long long>(number), " ", plain(label), "\n");
        is_feed_told_ = false;
    }

    void finish() { write("G0 X0 Y0\n", machine_ == Machine::Marlin ? "" : "M2\n"); }

    void begin(Point at) {
        move("G0", at, machine_ == Machine::Marlin);
        is_touch_ = true;
    }

    void line_to(Point at) {
        if (std::exchange(is_touch_, false)) lower(down_);
        move("G1", at, true);
    }

    void end() {
        if (is_touch_) lower(dot_);
        write(up_);
        if (commands_set_feed_) is_feed_told_ = false;
    }

private:
    static constexpr std::array<std::string_view, 3> kDown = {"M3 S1000", "G1 Z0 F1000", "M4 S1000"};
    static constexpr std::array<std::string_view, 3> kUp = {"M5", "G1 Z5 F1000", "M5"};

    std::size_t index() const { return static_cast<std::size_t>(machine_); }

    static std::string commands(const std::string& given, std::string_view usual) {
        std::string lines(given.empty() ? usual : given);
        std::ranges::replace(lines, '|', '\n');
        return lines += '\n';
    }

    /// Returns the command for the pause of the pen; empty if there is none.
    static std::string pause_of(const Plotter& plotter) {
        if (!(plotter.pause() > 0)) return {};
        const bool in_ms = plotter.dwell_in_ms.value_or(plotter.machine == Machine::Marlin);
        const double seconds = std::max(plotter.pause(), 1e-3);
        std::string command = "G4 P";
        append_fixed(command, in_ms ? 1000 * seconds : seconds, in_ms ? 0 : 3);
        return command += '\n';
    }

    void lower(const std::string& commands) {
        write(commands);
        if (commands_set_feed_) is_feed_told_ = false;
    }

    void move(std::string_view command, Point at, bool has_feed) {
        const Point p = upright(at);
        write(command, " X", p.x, " Y", p.y);
        if (has_feed && !std::exchange(is_feed_told_, true)) write(" F", feed_);
        write("\n");
    }

    Machine machine_;
    double feed_;  ///< speed of the pen, mm per minute
    std::string down_;
    std::string up_;
    std::string dot_;         ///< what lowers the pen for a touch
    bool commands_set_feed_;  ///< whether the commands of the pen change the speed, which then must be set again
    bool is_feed_told_ = false;
    bool is_touch_ = false;
};

/// Returns the index of the nearest colour in AutoCAD's palette. Index 7 is black on a white background.
int index_of(const Colour& colour) {
    constexpr std::array<Colour, 9> kIndexed = {{{255, 0, 0},
                                                 {255, 255, 0},
                                                 {0, 255, 0},
                                                 {0, 255, 255},
                                                 {0, 0, 255},
                                                 {255, 0, 255},
                                                 kBlack,
                                                 {128, 128, 128},
                                                 {192, 192, 192}}};
    const auto distance = [&](const Colour& other) { return squared_distance(colour, other); };
    return 1 + static_cast<int>(std::ranges::min_element(kIndexed, {}, distance) - kIndexed.begin());
}

class Dxf : public PlotterFile {
public:
    Dxf(const Plot& plot, Body& body, const std::stop_token& stop)
        : PlotterFile(plot, body, stop), is_filled_(plot.style == DotStyle::Fill) {
        for (const Pen& pen : plot.pens)
            layers_.push_back("PEN" + std::to_string(layers_.size() + 1) + "_" + plain(pen.label));
    }

    void initialise(const Plot& plot) {
        write("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$EXTMIN\n10\n0\n20\n0\n9\n$EXTMAX\n");
        write("10\n", size().x, "\n20\n", size().y, "\n9\n$INSUNITS\n70\n4\n9\n$MEASUREMENT\n70\n1\n");  // millimetres
        write("0\nENDSEC\n0\nSECTION\n2\nTABLES\n");
        write("0\nTABLE\n2\nLTYPE\n70\n1\n0\nLTYPE\n2\nCONTINUOUS\n70\n0\n3\nSolid\n72\n65\n73\n0\n40\n0\n0\nENDTAB\n");
        write("0\nTABLE\n2\nLAYER\n70\n", static_cast<long long>(layers_.size()), "\n");
        for (std::size_t i = 0; i < layers_.size(); ++i) {
            write("0\nLAYER\n2\n", layers_[i], "\n70\n0\n62\n", static_cast<long long>(index_of(plot.pens[i].colour)),
                  "\n6\nCONTINUOUS\n");
        }
        write("0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    }

    void select(std::size_t number, const Pen& pen) {
        layer_ = layers_[number];
        radius_ = pen.radius;
    }

    void finish() { write("0\nENDSEC\n0\nEOF\n"); }

    void begin(Point at) {
        start_ = at;
        is_touch_ = true;
    }

    void line_to(Point at) {
        if (is_touch_) {
            write("0\nPOLYLINE\n8\n", layer_, "\n66\n1\n10\n0\n20\n0\n30\n0\n70\n0\n");
            position("VERTEX", start_);
        }
        position("VERTEX", at);
        is_touch_ = false;
    }

    void end() {
        if (!is_touch_) return write("0\nSEQEND\n8\n", layer_, "\n");
        position(is_filled_ ? "CIRCLE" : "POINT", start_);
        if (is_filled_) write("40\n", radius_, "\n");
    }

private:
    void position(std::string_view entity, Point at) {
        const Point p = upright(at);
        write("0\n", entity, "\n8\n", layer_, "\n10\n", p.x, "\n20\n", p.y, "\n30\n0\n");
    }

    std::vector<std::string> layers_;
    bool is_filled_;
    std::string layer_;
    double radius_ = 0;
    Point start_;
    bool is_touch_ = false;
};

}  // namespace

void write_hpgl(const Plot& plot, Body& body, const std::stop_token& stop) {
    Hpgl file(plot, body, stop);
    file.initialise();
    for (std::size_t i = 0; i < plot.pens.size(); ++i) {
        file.select(i + 1);
        trace(plot, plot.pens[i], file);
    }
    file.finish();
}

void write_gcode(const Plot& plot, Body& body, const std::stop_token& stop) {
    Gcode file(plot, body, stop);
    file.initialise(plot);
    for (std::size_t i = 0; i < plot.pens.size(); ++i) {
        file.select(i + 1, plot.pens[i].label);
        trace(plot, plot.pens[i], file);
    }
    file.finish();
}

void write_dxf(const Plot& plot, Body& body, const std::stop_token& stop) {
    Dxf file(plot, body, stop);
    file.initialise(plot);
    for (std::size_t i = 0; i < plot.pens.size(); ++i) {
        file.select(i, plot.pens[i]);
        trace(plot, plot.pens[i], file);
    }
    file.finish();
}

}  // namespace ccdt::api
