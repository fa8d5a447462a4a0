// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample_cost.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <string>

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include "api/analyze/analyze.h"
#include "api/halftone/halftone.h"
#include "api/halftone/halftone_cost.h"
#include "api/image/png_writer.h"
#include "api/sample/mask/threshold_mask.h"
#include "api/sample/pixels/pixel_sample.h"
#include "api/sample/plane/sample.h"
#include "api/sample/plane/sample_parser.h"
#include "api/sample/spatial/surface_sample.h"
#include "api/sample/spatial/volume_sample.h"
#include "tests/api/files.h"
#include "tests/api/image/rasters.h"
#include "tests/support/halftone_requests.h"
#include "tests/support/surfaces.h"

namespace ccdt::api {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMemoryIsOurs = false;
#else
constexpr bool kMemoryIsOurs = true;
#endif

constexpr double kMebibyte = 1 << 20;

/// Returns an entry of /proc/self/status, in kibibytes.
std::size_t status(const std::string& name) {
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with(name + ":")) return std::stoul(line.substr(name.size() + 1));
    }
    return 0;
}

/// Runs a function in a separate process, and returns by how many bytes its resident memory rose at most.
double peak_of(const std::function<void()>& work) {
    int ends[2];
    if (pipe(ends) != 0) return -1;
    const pid_t child = fork();
    if (child == 0) {
        malloc_trim(0);
        std::ofstream("/proc/self/clear_refs") << 5;
        const std::size_t before = status("VmRSS");
        work();
        const std::size_t grown = status("VmHWM") - before;
        _exit(write(ends[1], &grown, sizeof(grown)) == sizeof(grown) ? 0 : 1);
    }
    close(ends[1]);
    std::size_t grown = 0;
    const bool received = read(ends[0], &grown, sizeof(grown)) == sizeof(grown);
    close(ends[0]);
    waitpid(child, nullptr, 0);
    return received ? static_cast<double>(grown) * 1024 : -1;
}

/// Checks that the memory taken is less than the estimate, and that the estimate is at most `most` times the memory
/// taken, plus 8 MiB. A higher estimate would delay other requests needlessly.
void expect_near(const Cost& cost, double most, const std::function<void()>& work, const std::string& name) {
    const double peak = peak_of(work);
    const auto estimate = static_cast<double>(cost.memory);
    EXPECT_GT(peak, 0) << name;
    EXPECT_LT(peak, estimate) << name;
    EXPECT_GT(peak * most + 8 * kMebibyte, estimate) << name;
}

struct SampleCase {
    std::string name;
    std::string body;
    double most = 3;  ///< limit of the ratio of estimated to taken memory

    friend void PrintTo(const SampleCase& each, std::ostream* out) { *out << each.name; }
};

std::string circle(int corners) {
    std::string text = R"("polygon":[)";
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * 3.141592653589793 * i / corners;
        text += (i > 0 ? ",[" : "[") + std::to_string(std::cos(angle)) + ',' + std::to_string(std::sin(angle)) + ']';
    }
    return text + ']';
}

/// Returns a polygon with the maximum number of self-intersections: each edge spans almost half a turn.
std::string scribble(int corners) {
    std::string text = R"("polygon":[)";
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * 3.141592653589793 * i * (corners / 2) / corners;
        const double radius = 1 + 0.1 * std::sin(7.0 * i);  // so that no two crossings coincide
        text += (i > 0 ? ",[" : "[") + std::to_string(radius * std::cos(angle)) + ',' +
                std::to_string(radius * std::sin(angle)) + ']';
    }
    return text + ']';
}

template <class Value>
std::string grid(int side, Value&& value) {
    std::string text =
        R"("density":{"width":)" + std::to_string(side) + R"(,"height":)" + std::to_string(side) + R"(,"values":[)";
    for (int i = 0; i < side * side; ++i) text += (i > 0 ? "," : "") + std::to_string(value(i));
    return text + "]}";
}

std::string grid(int side) {
    return grid(side, [](int i) { return 1 + i % 7; });
}

/// Returns a density grid with a tenth of black cells and the rest white, which needs the finest transport grids.
std::string blots(int side) {
    return grid(side, [](int i) { return i * 7919 % 10 == 0 ? 1 : 0; });
}

/// Returns a dot map of side x side features, each with `points` points of each class.
std::string squares(int side, int points, const std::string& options = R"("sites":"a")") {
    std::string text = options + R"(,"geometry":{"type":"FeatureCollection","features":[)";
    const std::string count = std::to_string(points);
    for (int i = 0; i < side * side; ++i) {
        const std::string west = std::to_string(0.05 * (i % side)), east = std::to_string(0.05 * (i % side + 1));
        const std::string south = std::to_string(0.05 * (i / side)), north = std::to_string(0.05 * (i / side + 1));
        text += (i > 0 ? "," : "") + std::string(R"({"type":"Feature","properties":{"a":)") + count + R"(,"b":)" +
                count + R"(},"geometry":{"type":"Polygon","coordinates":[[[)" + west + ',' + south + "],[" + east +
                ',' + south + "],[" + east + ',' + north + "],[" + west + ',' + north + "]]]}}";
    }
    return text + "]}";
}

class SampleCost : public testing::TestWithParam<SampleCase> {};

TEST_P(SampleCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    const auto request = parse_sample('{' + GetParam().body + '}', {}, "", {});
    ASSERT_TRUE(request) << request.error().message;
    const auto work = [&] {
        Timings timings;
        const auto answer = request->threshold_mask ? run_mask(*request->threshold_mask, {}, timings)
                                                    : run_sample(*request, {}, decode_inline(), {}, timings);
        if (!answer) _exit(1);
    };
    expect_near(cost_of(*request, {}), GetParam().most, work, GetParam().name);
}

const std::string kSquare = R"("domain":{"type":"rectangle","width":1,"height":1})";
const std::string kTorus = R"("domain":{"type":"torus","width":1,"height":1})";

INSTANTIATE_TEST_SUITE_P(
    Requests, SampleCost,
    testing::Values(
        SampleCase{"draft", R"("sites":100000,"quality":"draft",)" + kSquare},
        SampleCase{"standard", R"("sites":100000,)" + kSquare},
        SampleCase{"best", R"("sites":50000,"quality":"best",)" + kSquare},
        SampleCase{"stealthy", R"("sites":50000,"quality":"stealthy",)" + kTorus},
        SampleCase{"progressive", R"("sites":100000,"order":"progressive","quality":"draft",)" + kSquare},
        SampleCase{"path", R"("sites":100000,"order":"path","quality":"draft",)" + kSquare},
        SampleCase{"mask", R"("format":"mask16","domain":{"type":"torus","width":512,"height":512})"},
        SampleCase{"torus", R"("sites":100000,)" + kTorus},
        SampleCase{"mesh", R"("sites":100000,"mesh":true,)" + kSquare},
        SampleCase{"start", R"("sites":100000,"iterations":0,)" + kSquare},
        SampleCase{"polygon", R"("sites":100000,)" + circle(100)},
        SampleCase{"globe", R"("sites":100000,"coordinates":"lonlat",)" + circle(100), 6},
        SampleCase{"corners", R"("sites":1000,)" + circle(60'000), 6},
        SampleCase{"crossings", R"("sites":1000,)" + scribble(301), 6},
        SampleCase{"coarse", R"("sites":60000,)" + grid(64) + ',' + kSquare},
        SampleCase{"blots", R"("sites":60000,)" + blots(64) + ',' + kSquare},
        SampleCase{"blots_torus", R"("sites":60000,)" + blots(64) + ',' + kTorus},
        SampleCase{"blots_draft", R"("sites":60000,"quality":"draft",)" + blots(64) + ',' + kSquare},
        SampleCase{"weighed_polygon", R"("sites":60000,"quality":"draft",)" + grid(64) + ',' + circle(100)},
        SampleCase{"fine", R"("sites":2000,)" + grid(1000) + ',' + kSquare},
        SampleCase{"cvt", R"("sites":10000,"method":"cvt","iterations":3,)" + kTorus},
        SampleCase{"odt", R"("sites":100000,"method":"odt","iterations":3,)" + kSquare},
        SampleCase{"ccvt", R"("sites":4096,"method":"ccvt","iterations":3,)" + kSquare},
        SampleCase{"random", R"("sites":200000,"method":"random",)" + kSquare},
        SampleCase{"csv", R"("sites":200000,"method":"random","format":"csv",)" + kSquare},
        SampleCase{"geojson", R"("sites":200000,"method":"random","format":"geojson",)" + kSquare},
        SampleCase{"split", R"("sites":200000,"method":"random","format":"svg","split":"ink",)" + kSquare},
        SampleCase{"svg", R"("sites":200000,"method":"random","format":"svg",)" + kSquare},
        SampleCase{"pdf", R"("sites":200000,"method":"random","format":"pdf","width_mm":300,)" + kSquare},
        SampleCase{"dxf", R"("sites":200000,"method":"random","format":"dxf","width_mm":300,)" + kSquare},
        SampleCase{"png", R"("sites":100000,"method":"random","format":"png",)" + kSquare},
        SampleCase{"map", squares(3, 11'111)}, SampleCase{"map_of_many", squares(100, 2), 6},
        SampleCase{"map_best", squares(3, 11'111, R"("sites":"a","quality":"best")")},
        SampleCase{"map_draft", squares(3, 11'111, R"("sites":"a","quality":"draft")")},
        SampleCase{"map_classes", squares(3, 5'555, R"("classes":["a","b"])")},
        SampleCase{"map_png", squares(3, 11'111, R"("sites":"a","coordinates":"lonlat","format":"png")"), 6},
        SampleCase{"map_svg", squares(3, 11'111, R"("sites":"a","coordinates":"lonlat","format":"svg")"), 6},
        SampleCase{"map_globe", squares(3, 11'111, R"("sites":"a","coordinates":"lonlat")"), 6},
        SampleCase{"map_buffer", squares(3, 11'111, R"("sites":"a","buffer":0.01)")},
        SampleCase{"map_fixed", squares(30, 11, R"("sites":"a","fixed":[[0.1,0.1],[0.2,0.2],[1,1]])"), 7},
        SampleCase{"wide", R"("sites":1000,"method":"random","format":"png","width":4000,)" + kSquare}),
    [](const auto& each) { return each.param.name; });

class PixelCost : public testing::TestWithParam<SampleCase> {};

TEST_P(PixelCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    const auto document =
        JsonDocument::parse(R"({"domain":{"type":"pixels","width":1200,"height":1000},)" + GetParam().body + '}');
    const auto request = parse_pixels(document->root(), {}, "", {});
    ASSERT_TRUE(request) << request.error().message;
    const auto work = [&] {
        Timings timings;
        if (!run_pixels(*request, {}, decode_inline(), {}, timings)) _exit(1);
    };
    expect_near(cost_of(*request, {}), GetParam().most, work, GetParam().name);
}

INSTANTIATE_TEST_SUITE_P(Requests, PixelCost,
                         testing::Values(SampleCase{"json", R"("sites":300000)", 2},
                                         SampleCase{"csv", R"("sites":600000,"format":"csv")", 2},
                                         SampleCase{"png", R"("sites":300000,"format":"png")", 2},
                                         SampleCase{"npy", R"("sites":300000,"format":"npy")", 2},
                                         SampleCase{"blocks",
                                                    R"("sites":300000,"format":"npy","calibration":{"width":99})", 2},
                                         SampleCase{"density", R"("sites":300000,"format":"npy",)" + grid(1000), 2}),
                         [](const auto& each) { return each.param.name; });

struct HalftoneCase {
    std::string name;
    std::vector<TextOption> options;
    double most = 4;
    std::string picture = "camera.png";

    friend void PrintTo(const HalftoneCase& each, std::ostream* out) { *out << each.name; }
};

const std::string kColours = "astronaut.png";

class HalftoneCost : public testing::TestWithParam<HalftoneCase> {};

TEST_P(HalftoneCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    const std::string file = photograph(GetParam().picture);
    const auto request = parse_halftone(file, GetParam().options, "", {});
    ASSERT_TRUE(request) << request.error().message;
    const auto work = [&] {
        Timings timings;
        if (!run_halftone(*request, {}, decode_inline(), {}, timings)) _exit(1);
    };
    expect_near(cost_of(*request, {}), GetParam().most, work, GetParam().name);
}

INSTANTIATE_TEST_SUITE_P(
    Requests, HalftoneCost,
    testing::Values(
        HalftoneCase{"usual", {{"scale", "2"}}, 6}, HalftoneCase{"dots", {{"sites", "65536"}, {"scale", "1"}}},
        HalftoneCase{"ink", {{"sites", "65536"}, {"scale", "1"}, {"dots", "ink"}}},
        HalftoneCase{"ink_vectors", {{"sites", "65536"}, {"format", "svg"}, {"scale", "4"}, {"dots", "ink"}}},
        HalftoneCase{"both_points", {{"sites", "65536"}, {"format", "json"}, {"dots", "both"}}},
        HalftoneCase{"both_draft", {{"sites", "65536"}, {"quality", "draft"}, {"format", "npy"}, {"dots", "both"}}},
        HalftoneCase{"both_few", {{"sites", "20000"}, {"quality", "draft"}, {"detail", "0"}, {"scale", "1"}}},
        HalftoneCase{"draft", {{"sites", "65536"}, {"quality", "draft"}, {"scale", "1"}}},
        HalftoneCase{"levels", {{"sites", "2000"}, {"scale", "1"}, {"levels", "0.1,0.9,1.2"}}, 6},
        HalftoneCase{"screen", {}, 6}, HalftoneCase{"screen_cmyk", {{"color", "cmyk"}}, 6.5, kColours},
        HalftoneCase{"small", {{"width", "200"}}, 6}, HalftoneCase{"wide", {{"width", "5000"}}},
        HalftoneCase{"middle", {{"width", "3000"}, {"height", "500"}, {"fit", "cover"}}, 6},
        HalftoneCase{"large", {{"sites", "2000"}, {"scale", "8"}}, 4.5},
        HalftoneCase{"smooth", {{"sites", "2000"}, {"scale", "8"}, {"antialias", "true"}}},
        HalftoneCase{"points", {{"sites", "65536"}, {"format", "json"}}},
        HalftoneCase{"webp", {{"sites", "2000"}, {"scale", "8"}, {"format", "webp"}}},
        HalftoneCase{"smooth_webp", {{"sites", "2000"}, {"scale", "8"}, {"format", "webp"}, {"antialias", "true"}}},
        HalftoneCase{"smooth_jpeg", {{"sites", "2000"}, {"scale", "8"}, {"format", "jpeg"}, {"antialias", "true"}}},
        HalftoneCase{"best_jpeg", {{"sites", "2000"}, {"scale", "8"}, {"format", "jpeg"}, {"jpeg_quality", "100"}}},
        HalftoneCase{"tiff", {{"sites", "2000"}, {"scale", "8"}, {"format", "tiff"}}, 4.5},
        HalftoneCase{"vectors", {{"sites", "65536"}, {"format", "svg"}, {"scale", "4"}}},
        HalftoneCase{"pdf", {{"sites", "65536"}, {"format", "pdf"}, {"width_mm", "200"}, {"scale", "4"}}},
        HalftoneCase{"spirals",
                     {{"sites", "5000"},
                      {"format", "gcode"},
                      {"style", "spiral"},
                      {"pen", "0.1"},
                      {"width_mm", "500"},
                      {"scale", "1"}},
                     6},
        HalftoneCase{"pdf_circles",
                     {{"sites", "5000"},
                      {"format", "pdf"},
                      {"style", "circles"},
                      {"pen", "0.3"},
                      {"width_mm", "300"},
                      {"scale", "1"}},
                     6},
        HalftoneCase{"cmyk", {{"color", "cmyk"}, {"sites", "65536"}, {"scale", "1"}}, 4, kColours},
        HalftoneCase{"rgb", {{"color", "rgb"}, {"sites", "2000"}, {"scale", "8"}}, 4, kColours},
        HalftoneCase{
            "palette", {{"palette", "#000,#f00,#0f0,#00f,#ff0,#0ff"}, {"sites", "2000"}, {"scale", "1"}}, 6, kColours},
        HalftoneCase{
            "smooth_cmyk", {{"color", "cmyk"}, {"sites", "2000"}, {"scale", "8"}, {"antialias", "true"}}, 4, kColours},
        HalftoneCase{"clear_cmyk",
                     {{"color", "cmyk"},
                      {"sites", "2000"},
                      {"scale", "8"},
                      {"antialias", "true"},
                      {"background", "transparent"},
                      {"format", "webp"}},
                     4,
                     kColours},
        HalftoneCase{
            "cmyk_tiff", {{"color", "cmyk"}, {"sites", "2000"}, {"scale", "8"}, {"format", "tiff"}}, 4, kColours},
        HalftoneCase{"palette_both",
                     {{"palette", "#ff48b0,#0078bf,#ffe800,#000"}, {"dots", "both"}, {"sites", "16000"}},
                     4,
                     kColours},
        HalftoneCase{"palette_both_few", {{"palette", "#ff48b0,#0078bf"}, {"sites", "2000"}}, 2.5, kColours},
        HalftoneCase{"cmyk_points", {{"color", "cmyk"}, {"sites", "65536"}, {"format", "json"}}, 4, kColours},
        HalftoneCase{
            "cmyk_vectors", {{"color", "cmyk"}, {"sites", "65536"}, {"format", "svg"}, {"scale", "4"}}, 4, kColours}),
    [](const auto& each) { return each.param.name; });

TEST(HalftoneCost, BoundsMemoryUsedForManyPixels) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    Raster raster{1600, 1600, 1, {}};
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x)
            raster.coverage.push_back(static_cast<std::uint8_t>(128 + 120 * std::sin(x / 23.0) * std::sin(y / 31.0)));
    }
    const std::string file = *write_png(image_of(raster, true));
    for (const auto* dots : {"ink", "both"}) {
        for (const auto* sites : {"60000", "200000"}) {
            const std::vector<TextOption> options = {
                {"dots", dots}, {"sites", sites}, {"quality", "draft"}, {"iterations", "1"}, {"format", "json"}};
            const auto request = parse_halftone(file, options, "", {});
            ASSERT_TRUE(request) << request.error().message;
            const auto work = [&] {
                Timings timings;
                if (!run_halftone(*request, {}, decode_inline(), {}, timings)) _exit(1);
            };
            expect_near(cost_of(*request, {}), 3, work, std::string(dots) + " " + sites);
        }
    }
}

TEST(SampleCost, BoundsAnswerSizeFromBelow) {
    const auto least = [](const std::string& format) {
        const auto request = parse_sample(R"({"sites":1000,"format":")" + format + "\"," + kSquare + '}', {}, "", {});
        Timings timings;
        const auto answer = run_sample(*request, {}, decode_inline(), {}, timings);
        const std::size_t known = cost_of(*request, {}).answer;
        EXPECT_LE(known, answer->body.size()) << format;
        return known;
    };
    EXPECT_EQ(least("npy"), 16'000U);
    for (const char* text : {"json", "csv", "geojson"}) EXPECT_GT(least(text), 0U);
    for (const char* drawing : {"svg", "png"}) EXPECT_EQ(least(drawing), 0U);
}

TEST(SampleCost, BoundsAnswerSizeFromAbove) {
    const auto check = [](const std::string& more, std::size_t most) {
        const auto request = parse_sample(R"({"sites":3000,"iterations":0,)" + more + '}', {}, "", {});
        ASSERT_TRUE(request) << request.error().message;
        Timings timings;
        const auto answer = run_sample(*request, {}, decode_inline(), {}, timings);
        ASSERT_TRUE(answer) << answer.error().message;
        const std::size_t largest = largest_answer(*request, {});
        EXPECT_GE(largest, answer->body.size()) << more;
        EXPECT_LE(largest, answer->body.size() * most + 16'384) << more;
    };
    const std::string tiny = R"("domain":{"type":"torus","width":1.1e-5,"height":1.3e-6})";
    const std::string area =
        R"("properties":"*","geometry":{"type":"Feature","id":"the id","properties":{"name":"a \"name\"","n":1e-9},)"
        R"("geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,0]]]}})";
    for (const char* format : {"json", "csv", "geojson", "ndjson", "geojsonseq", "npy", "svg"})
        check(tiny + R"(,"format":")" + format + '"', 3);
    for (const char* format : {"json", "csv", "geojson", "ndjson", "geojsonseq"})
        check(area + R"(,"format":")" + format + '"', 3);
    for (const char* format : {"pdf", "eps", "hpgl", "gcode", "dxf"})
        for (const char* style : {"", R"(,"style":"spiral","pen":0.1)"})
            check(tiny + R"(,"width_mm":100,"format":")" + format + '"' + style, 12);
    check(tiny + R"(,"mesh":true)", 3);
    check(tiny + R"(,"format":"png")", 8);
}

TEST(AnalyzeCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    std::string points, in_space;
    for (int i = 0; i < 20'000; ++i) {
        const std::string start = (i > 0 ? ",[" : "[") + std::to_string(std::fmod(i * 0.7548776662, 1)) + ',' +
                                  std::to_string(std::fmod(i * 0.5698402910, 1));
        points += start + ']';
        in_space += start + ',' + std::to_string(std::fmod(i * 0.8191725134, 1)) + ']';
    }
    const auto check = [](const std::string& body) {
        const auto request = parse_analyze(body, "", {});
        ASSERT_TRUE(request) << request.error().message;
        const auto work = [&] {
            Timings timings;
            if (!run_analyze(*request, {}, timings)) _exit(1);
        };
        expect_near(cost_of(*request), 3, work, body.substr(body.size() - 60));
    };
    for (const auto* more :
         {"", R"(,"spectrum":true)", R"(,"format":"png")", R"(,"max_frequency":8)", R"(,"max_frequency":16)"})
        check(R"({"points":[)" + points + "]" + more + ',' + kTorus + '}');
    for (const auto* more : {"", R"(,"max_frequency":4)"}) check(R"({"points":[)" + in_space + "]" + more + '}');
}

TEST(SurfaceCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    struct Case {
        std::string name;
        TriangleSoup soup;
        std::vector<TextOption> options;
    };
    const TriangleSoup coarse = test::torus_surface(1, 0.3, 20, 20), fine = test::torus_surface(1, 0.3, 300, 300);
    const TriangleSoup thin = test::torus_surface(1, 1e-3, 300, 8);
    TriangleSoup rod = test::cube_surface();
    for (Point3& vertex : rod.vertices) vertex = {vertex.x, 1e-3 * vertex.y, 1e-3 * vertex.z};
    const std::vector<Case> cases = {
        {"coarse", coarse, {{"sites", "30000"}, {"format", "npy"}}},
        {"draft", coarse, {{"sites", "30000"}, {"format", "npy"}, {"quality", "draft"}}},
        {"mesh", coarse, {{"sites", "30000"}, {"mesh", "true"}}},
        {"draft with mesh", coarse, {{"sites", "30000"}, {"mesh", "true"}, {"quality", "draft"}}},
        {"progressive", coarse, {{"sites", "30000"}, {"order", "progressive"}, {"format", "ply"}}},
        {"thin", thin, {{"sites", "30000"}, {"format", "npy"}}},
        {"rod", rod, {{"sites", "20000"}, {"format", "npy"}}},
        {"fine", fine, {{"sites", "10"}}},
        {"fixed", fine, {{"sites", "10"}, {"density", "curvature"}, {"fixed", "[[1,0,0]]"}}}};
    for (const auto& [name, soup, options] : cases) {
        SurfaceFile file;
        file.header.max_triangles = soup.triangles.size();
        file.header.max_vertices = soup.vertices.size();
        const auto request = parse_surface(file, options, "", {});
        ASSERT_TRUE(request) << request.error().message;
        Decode decode;
        decode.surface = [&soup = soup](std::string_view, const SurfaceHeader&, const std::stop_token&) {
            return Result<SurfaceContents>(SurfaceContents{soup});
        };
        const auto work = [&] {
            Timings timings;
            if (!run_sample3(*request, decode, {}, timings)) std::abort();
        };
        expect_near(cost_of(*request), 3, work, name);
    }
}

/// @param most  limit of the ratio of estimated to taken memory
void expect_volume_near(const std::string& body, double most = 3) {
    const auto document = JsonDocument::parse(body + '}');
    ASSERT_TRUE(document) << document.error().message;
    const auto request = parse_volume(document->root(), {}, "", {});
    ASSERT_TRUE(request) << request.error().message;
    const auto work = [&] {
        Timings timings;
        if (!run_sample3(*request, {}, {}, timings)) std::abort();
    };
    expect_near(cost_of(*request), most, work, body.substr(0, 200));
}

TEST(VolumeCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    const std::string torus =
        R"({"sites":20000,"domain":{"type":"torus","width":1,"height":1,"depth":1},"format":"npy")";
    std::string box = torus, voxels = "{\"width\":100,\"height\":100,\"depth\":100,\"values\":[";
    box.replace(box.find("torus"), 5, "box");
    for (int i = 0; i < 1'000'000; ++i) voxels += i % 100 < 50 ? "1," : "2,";
    voxels.back() = ']';
    const std::string few = R"({"sites":10,"domain":{"type":"box","width":1,"height":1,"depth":1},"density":)";
    for (const std::string& body : {torus + R"(,"quality":"draft","mesh":true)", box + R"(,"order":"progressive")",
                                    torus + R"(,"quality":"stealthy")", few + voxels + '}'})
        expect_volume_near(body);
}

TEST(VolumeCost, CountsTheCopiesOfThinDomains) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    const std::string rod =
        R"({"sites":5000,"domain":{"type":"torus","width":1,"height":1e-9,"depth":1e-9},"format":"npy")";
    for (const std::string& body : {rod, rod + R"(,"quality":"draft","mesh":true)"}) expect_volume_near(body, 5);
}

TEST(ParsingCost, BoundsMemoryUsed) {
    if (!kMemoryIsOurs) GTEST_SKIP() << "sanitizers use memory of their own";
    std::string rings, words, numbers, pairs;
    for (int i = 0; i < 300'000; ++i) {
        rings += "[],";
        words += "\"a\",";
        numbers += "1,";
        pairs += "[0.123456789,0.123456789],";
    }
    for (const std::string& list : {rings, words, numbers, pairs, std::string(3'000'000, ' ')}) {
        const std::string body = R"({"polygon":[)" + list + "0]}";
        expect_near(
            cost_of_parsing(body), 6, [&] { static_cast<void>(parse_sample(body, {}, "", {})); }, body.substr(12, 8));
    }
}

TEST(Cost, EstimatesTimeOfShortRequests) {
    const auto seconds = [](const std::string& body) { return cost_of(*parse_sample(body, {}, "", {}), {}).seconds; };
    EXPECT_LT(seconds(R"({"sites":1000,)" + kSquare + '}'), 0.02);
    EXPECT_GT(seconds(R"({"sites":20000,)" + kSquare + '}'), 0.02);
    EXPECT_GT(seconds(R"({"sites":1000,"iterations":1000,)" + kSquare + '}'), 0.02);
    EXPECT_GT(seconds(R"({"sites":1000,"method":"cvt",)" + kSquare + '}'), 0.02);
}

TEST(Cost, IsFiniteForDegenerateDomains) {
    const std::vector<std::string> polygons = {
        "[[1,1],[1,1],[1,1]]",
        "[[0,0],[1,0],[2,0]]",
        "[[-1.7e308,-1.7e308],[1.7e308,-1.7e308],[1.7e308,1.7e308]]",
        "[[0,0],[5e-324,0],[5e-324,1.7e308]]",
    };
    for (const auto& polygon : polygons) {
        for (const std::string size : {"", R"(,"width":65535)", R"(,"width":1,"dot":1.7e308)", R"(,"dot":5e-324)"}) {
            const std::string body = R"({"sites":5,"format":"png","polygon":)" + polygon + size + '}';
            const Cost cost = cost_of(*parse_sample(body, {}, "", {}), {});
            EXPECT_TRUE(std::isfinite(cost.seconds) && cost.seconds >= 0) << body;
            EXPECT_LT(cost.memory, std::size_t{1} << 32) << body;
        }
    }
}

TEST(UsualSites, TakeAtMostTwoSecondsToPlace) {
    const std::string file = photograph("camera.png");
    const auto most = [&](const std::vector<TextOption>& options) {
        const auto request = parse_halftone(file, options, "", {});
        return usual_sites(*request, {512, 512}, 1e6, 1, {});
    };
    EXPECT_EQ(most({}), 100'000U);
    EXPECT_EQ(most({{"iterations", "1000"}}), 4096U) << "the minimum of the default number";
    for (const std::vector<TextOption>& options : {std::vector<TextOption>{{"quality", "best"}},
                                                   {{"iterations", "40"}, {"dots", "ink"}},
                                                   {{"color", "cmyk"}, {"dots", "ink"}}}) {
        const std::size_t sites = most(options);
        EXPECT_LT(sites, 100'000U);
        EXPECT_GT(sites, 4096U);
        const auto seconds = [&](std::size_t count) {
            std::vector<TextOption> given = options;
            given.insert(given.end(), {{"sites", std::to_string(count)}, {"scale", "0.1"}, {"format", "npy"}});
            return cost_of(*parse_halftone(file, given, "", {}), {}).seconds;
        };
        EXPECT_NEAR(seconds(sites) - seconds(1), 2, 0.1);
    }
}

TEST(UsualSites, AreFewerInThinPictures) {
    const auto most = [](std::uint32_t width, std::uint32_t height) {
        HalftoneRequest request;
        request.image.header.width = width;
        request.image.header.height = height;
        return usual_sites(request, {1000, 1000}, 1e6, 0, {});
    };
    const std::size_t square = most(1000, 1000), thin = most(1, 1'000'000);
    EXPECT_EQ(square, 100'000U);
    EXPECT_LT(thin, 60'000U);
    EXPECT_GE(thin, 4096U);
    EXPECT_EQ(most(1'000'000, 1), thin);
    EXPECT_EQ(most(2, 500'000), thin);
    EXPECT_EQ(most(100, 10'000), square);
}

TEST(UsualSites, FollowPictureBelowTimeLimit) {
    const auto request = parse_halftone(photograph("camera.png"), {{"scale", "2"}}, "", {});
    const PictureSize all = {512, 512};
    EXPECT_EQ(usual_sites(*request, all, 80'000, 0, {}), 10'000U);
    EXPECT_EQ(usual_sites(*request, all, 80'000, 0.04, {}), 20'000U);
    EXPECT_EQ(usual_sites(*request, all, 80'000, 0.04, {.max_sites = 7000}), 7000U);
}

TEST(UsualSites, FollowSizeOfDrawingForScreen) {
    const std::string file = photograph("camera.png");
    const auto sites = [&](const std::vector<TextOption>& options) {
        return usual_sites(*parse_halftone(file, options, "", {}), {512, 512}, 80'000, 0, {});
    };
    EXPECT_LT(sites({{"width", "200"}}), sites({{"width", "400"}}));
    EXPECT_LT(sites({{"width", "400"}}), sites({}));
    EXPECT_LT(sites({}), sites({{"width", "2000"}}));
    EXPECT_EQ(sites({}), sites({{"width", "1000"}})) << "the default size is the same";
    EXPECT_EQ(sites({{"width", "200"}, {"width_mm", "50"}}), 10'000U)
        << "in print, the number does not depend on the width in pixels";
}

TEST(Cost, IsEstimatedFromPictureHeader) {
    const std::string file = fixture("grey.jpg");
    const auto memory = [&](const std::vector<TextOption>& options) {
        return cost_of(*parse_halftone(file, options, "", {}), {}).memory;
    };
    EXPECT_LT(memory({{"sites", "10"}, {"scale", "1"}}), std::size_t{64} << 20);
    EXPECT_GT(memory({{"sites", "200000"}, {"scale", "1"}}), std::size_t{64} << 20);
}

}  // namespace
}  // namespace ccdt::api
