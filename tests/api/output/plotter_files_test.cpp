// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/plotter_files.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/api/output/whole_body.h"

namespace ccdt::api {
namespace {

const Box kBox = {{0, 0}, {10, 5}};

using Write = void (&)(const Plot&, Body&, const std::stop_token&);

/// Writes a plot with two pens, which draw two dots and one dot, on a page of 100 mm x 50 mm. The dots have a radius of
/// 0.5 mm.
std::string written(Write write, const DrawingOptions& drawing, const std::stop_token& stop = {}) {
    Distribution two, one;
    two.points = {{1, 1}, {3, 1.25}};
    one.points = {{0.01, 5}};
    const Ink red{"#ff0000", {255, 0, 0}}, black{"black", kBlack};
    const std::vector<InkDots> inks = {{red, two, 0.05}, {black, one, 0.05}};
    const Page page{kBox, false, false, {10, 5, 1}, 100};
    const Plot plot = plot_of({inks}, page, drawing, {});
    return test::whole_body([&](Body& body) { write(plot, body, stop); });
}

TEST(Hpgl, PutsThePenDownAtEachDot) {
    EXPECT_EQ(written(write_hpgl, {}), "IN;PA;\nSP1;\nPU400,1600;PD;\nPU1200,1500;PD;\nSP2;\nPU4,0;PD;\nPU;SP0;\n");
}

TEST(Hpgl, JoinsDotsByOneLine) {
    EXPECT_EQ(written(write_hpgl, {.style = DotStyle::Path}),
              "IN;PA;\nSP1;\nPU400,1600;PD1200,1500;\nSP2;\nPU4,0;PD;\nPU;SP0;\n");
}

TEST(Gcode, LowersAndLiftsThePen) {
    EXPECT_EQ(written(write_gcode, {.style = DotStyle::Stroke}),
              "; 3 dots, pen 1 mm, path 0.02 m, 0 min\nG21\nG90\nM5\nG4 P0.075\n"
              "; PEN 1 RED\nG0 X10 Y40\nM3 S1000\nG4 P0.075\nM5\nG4 P0.075\n"
              "G0 X30 Y37.5\nM3 S1000\nG4 P0.075\nM5\nG4 P0.075\n"
              "M0\n; PEN 2 BLACK\nG0 X0.1 Y0\nM3 S1000\nG4 P0.075\nM5\nG4 P0.075\n"
              "G0 X0 Y0\nM2\n");
}

TEST(Gcode, StatesDwellsInMilliseconds) {
    const std::string file = written(write_gcode, {.plotter = {.dwell = 0.0756, .dwell_in_ms = true}});
    EXPECT_NE(file.find("\nG21\nG90\nM5\nG4 P76\n"), std::string::npos);
    EXPECT_EQ(file.find("P0."), std::string::npos);
}

TEST(Gcode, HasTheCommandsOfTheMachine) {
    DrawingOptions drawing{.style = DotStyle::Path};
    drawing.plotter = {.speed = 10'000, .dwell = 0, .pen_down = "G1 Z-1 F300|S5", .pen_up = "G0 Z2"};
    EXPECT_EQ(written(write_gcode, drawing),
              "; 3 dots, pen 0.3 mm, path 0.02 m, 0 min\nG21\nG90\nG0 Z2\n; PEN 1 RED\nG0 X10 Y40\nG1 Z-1 F300\nS5\nG1 "
              "X30 Y37.5 F600000\nG0 Z2\n"
              "M0\n; PEN 2 BLACK\nG0 X0.1 Y0\nG1 Z-1 F300\nS5\nG0 Z2\nG0 X0 Y0\nM2\n");
}

TEST(Gcode, IsUnderstoodByMarlin) {
    EXPECT_EQ(written(write_gcode, {.style = DotStyle::Path, .plotter = {.machine = Machine::Marlin}}),
              "; 3 dots, pen 0.3 mm, path 0.02 m, 0 min\nG21\nG90\nG1 Z5 F1000\nG4 P75\n"
              "; PEN 1 RED\nG0 X10 Y40 F6000\nG1 Z0 F1000\nG4 P75\nG1 X30 Y37.5 F6000\nG1 Z5 F1000\nG4 P75\n"
              "M0\n; PEN 2 BLACK\nG0 X0.1 Y0 F6000\nG1 Z0 F1000\nG4 P75\nG1 Z5 F1000\nG4 P75\nG0 X0 Y0\n");
}

TEST(Gcode, BurnsLinesAndDotsButNoMoves) {
    DrawingOptions drawing{.style = DotStyle::Path, .plotter = {.machine = Machine::Laser}};
    EXPECT_EQ(written(write_gcode, drawing),
              "; 3 dots, pen 0.3 mm, path 0.02 m, 0 min\nG21\nG90\nM5\n"
              "; PEN 1 RED\nG0 X10 Y40\nM4 S1000\nG1 X30 Y37.5 F6000\nM5\n"
              "M0\n; PEN 2 BLACK\nG0 X0.1 Y0\nG1 F6000\nM3 S1000\nG4 P0.075\nM5\nG0 X0 Y0\nM2\n");
    drawing.plotter.pen_down = "M3 S200";
    const std::string file = written(write_gcode, drawing);
    EXPECT_NE(file.find("\nM3 S200\nG1 X30"), std::string::npos);
    EXPECT_NE(file.find("\nG1 F6000\nM3 S200\nG4"), std::string::npos);
}

TEST(Gcode, SetsTheSpeedAgainAfterCommandsThatChangeIt) {
    DrawingOptions drawing{.style = DotStyle::Circles, .pen_mm = 0.5};
    const auto speeds = [&] {
        const std::string file = written(write_gcode, drawing);
        std::size_t count = 0;
        for (std::size_t at = 0; (at = file.find(" F6000\n", at)) != std::string::npos; ++at) ++count;
        return count;
    };
    EXPECT_EQ(speeds(), 2U);  // once for each pen
    drawing.plotter.pen_down = "G1 Z-1 F300";
    EXPECT_EQ(speeds(), 3U);  // once for each dot
}

TEST(Dxf, HasALayerForEachPen) {
    const std::string file = written(write_dxf, {});
    EXPECT_TRUE(file.starts_with("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n"));
    EXPECT_NE(file.find("9\n$INSUNITS\n70\n4\n9\n$MEASUREMENT\n70\n1\n0\nENDSEC\n"), std::string::npos);
    EXPECT_NE(file.find("0\nLAYER\n2\nPEN1_RED\n70\n0\n62\n1\n6\nCONTINUOUS\n"), std::string::npos);
    EXPECT_NE(file.find("0\nLAYER\n2\nPEN2_BLACK\n70\n0\n62\n7\n6\nCONTINUOUS\n"), std::string::npos);
    EXPECT_TRUE(
        file.ends_with("2\nENTITIES\n"
                       "0\nCIRCLE\n8\nPEN1_RED\n10\n10\n20\n40\n30\n0\n40\n0.5\n"
                       "0\nCIRCLE\n8\nPEN1_RED\n10\n30\n20\n37.5\n30\n0\n40\n0.5\n"
                       "0\nCIRCLE\n8\nPEN2_BLACK\n10\n0.1\n20\n0\n30\n0\n40\n0.5\n"
                       "0\nENDSEC\n0\nEOF\n"));
}

TEST(Dxf, HasPointsForTouchesAndPolylinesForLines) {
    EXPECT_NE(
        written(write_dxf, {.style = DotStyle::Stroke}).find("0\nPOINT\n8\nPEN2_BLACK\n10\n0.1\n20\n0\n30\n0\n0\n"),
        std::string::npos);
    EXPECT_NE(
        written(write_dxf, {.style = DotStyle::Path})
            .find("0\nPOLYLINE\n8\nPEN1_RED\n66\n1\n10\n0\n20\n0\n30\n0\n70\n0\n"
                  "0\nVERTEX\n8\nPEN1_RED\n10\n10\n20\n40\n30\n0\n0\nVERTEX\n8\nPEN1_RED\n10\n30\n20\n37.5\n30\n0\n"
                  "0\nSEQEND\n8\nPEN1_RED\n"),
        std::string::npos);
}

TEST(PlotterFiles, EndOnceTheyAreStopped) {
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(written(write_hpgl, {}, source.get_token()), "IN;PA;\nSP1;\nSP2;\nPU;SP0;\n");
}

}  // namespace
}  // namespace ccdt::api
