// SPDX-License-Identifier: GPL-3.0-or-later
// Uses libccdt, and prints the results as JSON: memory PICTURE, a binary PPM.
#include <ccdt/ccdt.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <string>

namespace {

const char* separator = "{";

void begin(const std::string& name) {
    std::printf("%s\"%s\":", separator, name.c_str());
    separator = ",\n";
}

/// Prints a list of JSON values.
template <class List, class Print>
void print(const List& list, const Print& print_element) {
    const char* before = "[";
    for (const auto& element : list) {
        std::fputs(before, stdout);
        print_element(element);
        before = ",";
    }
    std::fputs(list.empty() ? "[]" : "]", stdout);
}

void print(const ccdt::Point& point) {
    std::printf("[%.17g,%.17g]", point.x, point.y);
}

void print(const std::vector<ccdt::Point>& points) {
    print(points, [](const ccdt::Point& point) { print(point); });
}

void print(const std::vector<ccdt::Point3>& points) {
    print(points, [](const ccdt::Point3& p) { std::printf("[%.17g,%.17g,%.17g]", p.x, p.y, p.z); });
}

void print(const std::vector<double>& values) {
    print(values, [](double value) { std::printf("%.17g", value); });
}

void print(const std::vector<std::uint32_t>& indices) {
    print(indices, [](std::uint32_t index) { std::printf("%u", index); });
}

void print(const ccdt::Triangulation& mesh) {
    std::fputs("{\"vertices\":", stdout);
    print(mesh.vertices);
    std::fputs(",\"triangles\":", stdout);
    print(mesh.triangles, [](const auto& t) { std::printf("[%u,%u,%u]", t[0], t[1], t[2]); });
    std::fputs(",\"boundary\":", stdout);
    print(mesh.boundary, [](const auto& loop) { print(loop); });
    std::fputs("}", stdout);
}

void print(const ccdt::Halftone& halftone) {
    std::printf("{\"width\":%d,\"height\":%d,\"channels\":%d,\"radius\":%.17g,\"points\":", halftone.width,
                halftone.height, halftone.channels, halftone.radius);
    print(halftone.points);
    std::fputs(",\"rings\":", stdout);
    print(halftone.rings, [](const auto& rings) { print(rings, [](const auto& ring) { print(ring); }); });
    std::fputs("}", stdout);
}

void print(const ccdt::PointAnalysis& analysis) {
    std::printf("{\"min_distance\":%.17g,\"mean_distance\":%.17g,\"low_frequency_power\":%.17g,\"power\":",
                analysis.min_distance, analysis.mean_distance, analysis.low_frequency_power.value_or(-1));
    print(analysis.power);
    std::printf(",\"width\":%d,\"height\":%d,\"spectrum\":%zu}", analysis.spectrum.width, analysis.spectrum.height,
                analysis.spectrum.power.size());
}

/// Prints the exception that a function throws.
void print_failure(const std::function<void()>& function) {
    try {
        function();
        std::fputs("null", stdout);
    } catch (const ccdt::Exception& exception) {
        std::printf("[%d,\"%s\",\"%s\"]", static_cast<int>(exception.code()), exception.field().c_str(),
                    exception.what());
    }
}

struct Pixels {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> colours;  ///< [height * width * 3]
};

Pixels read_ppm(const char* name) {
    Pixels pixels;
    std::ifstream file(name, std::ios::binary);
    std::string kind, most;
    file >> kind >> pixels.width >> pixels.height >> most;
    file.get();
    pixels.colours.resize(static_cast<std::size_t>(pixels.width * pixels.height) * 3);
    file.read(reinterpret_cast<char*>(pixels.colours.data()), static_cast<std::streamsize>(pixels.colours.size()));
    return pixels;
}

const ccdt::Polygon kSquareWithHole{{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{{1, 1}, {2, 1}, {2, 2}, {1, 2}}}};
const ccdt::Polygon kCrossing{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}};

void show_points() {
    ccdt::SampleOptions options;
    options.seed = 7;
    options.keep_triangulation = true;
    options.fixed = {{3, 3}, {0.5, 0.5}};
    options.density = ccdt::DensityGrid{2, 1, {1, 3}};
    const auto varied = ccdt::sample(kSquareWithHole, 300, options);
    begin("varied");
    print(varied.points);
    begin("trace");
    print(varied.trace);
    begin("mesh");
    print(*varied.triangulation);

    const auto uniform = ccdt::sample(ccdt::Torus{2, 1}, 500, {.quality = ccdt::Quality::Stealthy});
    begin("uniform");
    print(uniform.points);
    begin("order");
    print(ccdt::progressive_order(ccdt::Torus{2, 1}, uniform.points, true));
    begin("analysis");
    print(ccdt::analyze(uniform.points, ccdt::Torus{2, 1}));
    begin("analysis in space");
    print(ccdt::analyze({{0, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}}, ccdt::Torus3{1, 1, 1}));
    begin("repairs");
    std::printf("%zu", ccdt::sample(kCrossing, 10).repairs.size());
}

void show_volumes() {
    ccdt::VolumeOptions options;
    options.density = ccdt::VoxelGrid{1, 1, 2, {1, 3}};
    options.fixed = {{1, 0.5, 0.5}};
    options.progressive = options.keep_tetrahedra = true;
    const auto box = ccdt::sample_volume(ccdt::Box3{2, 1, 1}, 200, options);
    begin("box");
    print(box.points);
    begin("tetrahedra");
    print(box.tetrahedra->corners, [](const auto& t) { std::printf("[%u,%u,%u,%u]", t[0], t[1], t[2], t[3]); });
    begin("torus");
    print(ccdt::sample_volume(ccdt::Torus3{1, 1, 1}, 100, {.quality = ccdt::Quality::Stealthy}).points);
    ccdt::Solid solid{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
    begin("solid");
    print(ccdt::sample_volume(solid, 50).points);
    solid.triangles.pop_back();
    begin("open solid");
    print_failure([&] { ccdt::sample_volume(solid, 50); });
}

void show_halftones(const Pixels& pixels) {
    const ccdt::PictureView picture{pixels.width, pixels.height, 3, pixels.colours};
    begin("both");
    print(ccdt::halftone(picture, 900));
    begin("ink");
    print(ccdt::halftone(picture, 900, {.sides = ccdt::Sides::Ink, .seed = 3}, {.threads = 1}));
    begin("paper");
    print(ccdt::halftone(picture, 900, {.sides = ccdt::Sides::Paper, .tone = ccdt::Reproduction::Lightness}));
    begin("colour");
    print(ccdt::halftone(picture, 900, {.colour = true}));

    // Green as grey, opaque and with an alpha that rises from left to right.
    std::vector<std::uint8_t> grey, transparent;
    for (std::size_t i = 0; i < pixels.colours.size() / 3; ++i) {
        grey.push_back(pixels.colours[3 * i + 1]);
        transparent.insert(transparent.end(),
                           {grey.back(), static_cast<std::uint8_t>(i % static_cast<std::size_t>(pixels.width))});
    }
    begin("grey");
    print(ccdt::halftone({pixels.width, pixels.height, 1, grey}, 900));
    begin("transparent");
    print(ccdt::halftone({pixels.width, pixels.height, 2, transparent}, 900));
    begin("linear transparent");
    print(ccdt::halftone({pixels.width, pixels.height, 2, transparent}, 900, {.alpha = ccdt::Alpha::Linear}));

    // The same picture as floats in linear light, and with an opaque alpha.
    std::vector<float> light;
    for (std::size_t i = 0; i < pixels.colours.size(); ++i) {
        const float value = static_cast<float>(pixels.colours[i]) / 255;
        light.push_back(value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F));
        if (i % 3 == 2) light.push_back(1);
    }
    begin("floats");
    print(ccdt::halftone({pixels.width, pixels.height, 4, std::span<const float>(light)}, 900));
}

void show_failures(const Pixels& pixels) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<float> white(64, 1), black(64, 0);
    const auto halftone_of = [](const std::vector<float>& values, int width, ccdt::HalftoneOptions options = {}) {
        return ccdt::halftone({width, 8, 1, std::span<const float>(values)}, 10, options);
    };
    const std::map<std::string, std::function<void()>> failures = {
        {"no points",
         [] {
             ccdt::sample(ccdt::Rectangle{1, 1}, 0);
         }},
        {"no dots",
         [&] {
             ccdt::halftone({pixels.width, pixels.height, 3, pixels.colours}, 0);
         }},
        {"crossing", [] { ccdt::sample(kCrossing, 10, {.repair = false}); }},
        {"nan corner",
         [] {
             ccdt::sample(ccdt::Polygon{{{0, 0}, {1, kNan}, {1, 1}}}, 10);
         }},
        {"nan side",
         [] {
             ccdt::sample(ccdt::Rectangle{kNan, 1}, 10);
         }},
        {"nan fixed",
         [] {
             ccdt::sample(ccdt::Torus{1, 1}, 10, {.fixed = {{0, 0}, {kNan, 0}}});
         }},
        {"nan density",
         [] {
             ccdt::sample(ccdt::Torus{1, 1}, 9, {.density = ccdt::DensityGrid{2, 1, {1, kNan}}});
         }},
        {"few densities",
         [] {
             ccdt::sample(ccdt::Torus{1, 1}, 9, {.density = ccdt::DensityGrid{2, 2, {1, 2}}});
         }},
        {"empty polygon", [] { ccdt::sample(std::vector<ccdt::Polygon>{}, 10); }},
        {"large seed",
         [] {
             ccdt::sample(ccdt::Torus{1, 1}, 10, {.seed = ~std::uint64_t{0}});
         }},
        {"point outside",
         [] {
             ccdt::progressive_order(ccdt::Rectangle{1, 1}, std::vector<ccdt::Point>{{2, 0}});
         }},
        {"white", [&] { halftone_of(white, 8); }},
        {"black", [&] { halftone_of(black, 8, {.sides = ccdt::Sides::Paper}); }},
        {"wrong size", [&] { halftone_of(white, 9); }},
        {"no width", [&] { halftone_of(white, 0); }},
        {"five channels",
         [&] {
             ccdt::halftone({8, 8, 5, std::span<const float>(white)}, 10);
         }},
        {"colour of ink", [&] { halftone_of(black, 8, {.sides = ccdt::Sides::Ink, .colour = true}); }},
        {"nan detail", [&] { halftone_of(black, 8, {.detail = kNan}); }},
        {"high frequency",
         [] {
             ccdt::analyze({{0.5, 0.5}, {0.2, 0.2}}, ccdt::Torus{1, 1}, 17);
         }},
        {"analysis of polygon",
         [] {
             ccdt::analyze({{0.5, 0.5}, {0.2, 0.2}}, kSquareWithHole);
         }},
        {"analysis outside",
         [] {
             ccdt::analyze({{0.5, 0.5}, {3, 0.2}}, ccdt::Torus{1, 1});
         }},
        {"analysis of a solid",
         [] {
             ccdt::analyze({{0.5, 0.5, 0.5}, {0.2, 0.2, 0.2}}, ccdt::Solid());
         }},
        {"analysis of nan in space",
         [] {
             ccdt::analyze({{0.5, 0.5, 0.5}, {kNan, 0.2, 0.2}}, ccdt::Box3{1, 1, 1});
         }},
        {"analysis of nan",
         [] {
             ccdt::analyze({{0.5, 0.5}, {0, kNan}}, ccdt::Torus{1, 1});
         }},
    };
    for (const auto& [name, function] : failures) {
        begin(name);
        print_failure(function);
    }
    begin("solid black");
    print(halftone_of(black, 8));
}

void show_stops() {
    const ccdt::Torus torus{1, 1};
    std::stop_source source;
    ccdt::Control control{.stop = source.get_token(),
                          .progress = [&](const ccdt::Progress&) { source.request_stop(); }};
    begin("stopped");
    print_failure([&] { ccdt::sample(torus, 5000, {.iterations = 1000}, control); });

    std::stop_source other;
    control = {.stop = other.get_token(), .progress = [&](const ccdt::Progress&) { other.request_stop(); }};
    const auto partial = ccdt::sample(torus, 5000, {.iterations = 1000, .partial = true}, control);
    begin("partial");
    std::printf("[%d,%zu,%zu]", partial.stopped ? 1 : 0, partial.points.size(), partial.trace.size());

    std::vector<double> progress;
    ccdt::sample(torus, 100, {}, {.progress = [&](const ccdt::Progress& now) { progress.push_back(now.done); }});
    begin("progress");
    print(progress);

    begin("thrown");
    try {
        ccdt::sample(torus, 100, {}, {.progress = [](const ccdt::Progress&) { throw std::string("enough"); }});
    } catch (const std::string& text) {
        std::printf("\"%s\"", text.c_str());
    }
}

}  // namespace

int main(int, char** arguments) {
    const Pixels pixels = read_ppm(arguments[1]);
    begin("version");
    std::printf("\"%s\"", ccdt::version());
    show_points();
    show_volumes();
    show_halftones(pixels);
    show_failures(pixels);
    show_stops();
    std::puts("}");
}
