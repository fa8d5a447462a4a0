// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/halftone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "api/image/png_writer.h"
#include "api/text/numbers.h"
#include "tests/api/files.h"
#include "tests/api/image/rasters.h"
#include "tests/support/halftone_requests.h"

namespace ccdt::api {
namespace {

using Options = std::vector<TextOption>;

Result<HalftoneRequest> parse(const Options& options, std::string_view accept = "", const Limits& limits = {}) {
    static const std::string file = fixture("rgba.png");
    return parse_halftone(file, options, accept, limits);
}

Result<Answer> answer(const std::string& image, const Options& options, const Limits& limits = {}) {
    const auto request = parse_halftone(image, options, "", limits);
    if (!request) return tl::make_unexpected(request.error());
    Timings timings;
    return run_halftone(*request, limits, decode_inline(), {}, timings);
}

/// Returns the mean light of a picture that is entirely black and white.
double white_share(const DecodedPng& png) {
    double sum = 0;
    for (const auto& pixel : png.pixels) sum += pixel[0] / 255.0;
    return sum / static_cast<double>(png.pixels.size());
}

/// Returns a grey picture with so many pixels that it is downsampled for small numbers of dots.
std::string large_picture(int darkest) {
    Raster raster{2400, 1800, 1, {}};
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x)
            raster.coverage.push_back(static_cast<std::uint8_t>((x + y) * darkest / 4200));
    }
    return *write_png(image_of(raster, true));
}

/// An answer, and the reduction factors that the decoder was asked for: see Reading::reduce.
struct Asked {
    Answer answer;
    std::vector<int> reduced;
};

/// Answers a request with a decoder that records the reduction factors.
/// @param obey  whether the decoder reduces the picture
Asked ask(const std::string& image, const Options& options, bool obey) {
    Asked asked;
    const auto note = [&](const auto& decode) {
        return [&asked, &decode, obey](std::string_view bytes, const Reading& reading, const std::stop_token& stop) {
            asked.reduced.push_back(reading.reduce);
            return decode(bytes, {reading.max_pixels, obey ? reading.reduce : 1}, stop);
        };
    };
    const Decode whole = decode_inline();
    Timings timings;
    asked.answer =
        *run_halftone(*parse_halftone(image, options, "", {}), {}, {note(whole.grey), note(whole.colour)}, {}, timings);
    return asked;
}

TEST(Halftone, ReducesLargePicturesToResolutionOfDots) {
    const std::string image = large_picture(255);
    EXPECT_EQ(ask(image, {{"sites", "2000"}}, true).reduced, std::vector{4});
    EXPECT_EQ(ask(image, {{"sites", "2000"}, {"color", "cmyk"}, {"tone", "perceptual"}}, true).reduced, std::vector{4});
    EXPECT_EQ(ask(image, {{"sites", "15000"}, {"quality", "draft"}}, true).reduced, std::vector{2});
    const auto means = ask(image, {{"sites", "2000"}, {"format", "json"}}, true).answer;
    const auto whole = ask(image, {{"sites", "2000"}, {"format", "json"}}, false).answer;
    EXPECT_EQ(means.pixels, whole.pixels);
    EXPECT_EQ(means.sites, whole.sites);
    EXPECT_NEAR(means.dots->radius, whole.dots->radius, 1e-3 * whole.dots->radius);
}

TEST(Halftone, ReadsLargePicturesInFullForNonlinearTones) {
    const std::string image = large_picture(255);
    EXPECT_EQ(ask(image, {{"sites", "2000"}, {"tone", "perceptual"}}, true).reduced, std::vector{1});
    EXPECT_EQ(ask(image, {{"sites", "2000"}, {"levels", "0,0.9"}}, true).reduced, std::vector{1});
    EXPECT_EQ(ask(image, {{"dot", "9"}, {"quality", "draft"}}, true).reduced, std::vector{1})
        << "the number of dots follows from the picture";
}

TEST(Halftone, ReadsLargePicturesAgainIfDotsAreSmallerThanExpected) {
    const std::string image = large_picture(6);
    const Options options = {{"sites", "15000"}, {"quality", "draft"}, {"dots", "ink"}};
    const auto means = ask(image, options, true);
    EXPECT_EQ(means.reduced, (std::vector{2, 1}));
    EXPECT_EQ(means.answer.body, ask(image, options, false).answer.body);
}

TEST(HalftoneOptions, HaveDocumentedDefaults) {
    const auto request = parse({});
    ASSERT_TRUE(request);
    EXPECT_FALSE(request->sites || request->scale || request->width || request->height || request->dot);
    EXPECT_EQ(request->fit, Fit::Contain);
    EXPECT_TRUE(request->on_screen);
    EXPECT_EQ(request->palette.mixing, Mixing::Cover);
    EXPECT_EQ(request->palette.inks.front().colour, kBlack);
    EXPECT_EQ(request->palette.paper, kWhite);
    EXPECT_EQ(request->detail, 0.7);
    EXPECT_EQ(request->levels, Levels());
    EXPECT_TRUE(request->antialias);
    EXPECT_EQ(request->dots, Dots::Both);
    EXPECT_EQ(request->tone, Tone::Linear);
    EXPECT_EQ(request->format->file.name, "png");
    EXPECT_EQ(request->run.seed, 0U);
    EXPECT_EQ(request->run.iterations, 5);
    EXPECT_EQ(request->run.passes, 5);
    EXPECT_EQ(request->run.quality, quality_of_sites(Quality::Standard));
    EXPECT_EQ(parse({{"dots", "ink"}})->run.quality, Quality::Standard);
}

TEST(HalftoneOptions, ReadAllOptions) {
    const auto request = parse({{"sites", "20000"},
                                {"seed", "9007199254740991"},
                                {"iterations", "0"},
                                {"passes", "100"},
                                {"quality", "best"},
                                {"scale", "0.1"},
                                {"dot", "1.5"},
                                {"detail", "0.25"},
                                {"antialias", "true"},
                                {"dots", "paper"},
                                {"invert", "1"},
                                {"tone", "perceptual"},
                                {"alpha", "linear"},
                                {"foreground", "#123"},
                                {"background", "transparent"},
                                {"format", "json"}});
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->sites, 20000U);
    EXPECT_EQ(request->run.seed, 9007199254740991U);
    EXPECT_EQ(request->run.quality, Quality::Best);
    EXPECT_EQ(request->run.iterations, 0);
    EXPECT_EQ(request->run.passes, 100);
    EXPECT_EQ(request->scale, 0.1);
    EXPECT_EQ(request->dot->length, 1.5);
    EXPECT_EQ(request->detail, 0.25);
    EXPECT_TRUE(request->antialias);
    EXPECT_EQ(request->dots, Dots::Paper);
    EXPECT_EQ(request->tone, Tone::Perceptual);
    EXPECT_EQ(request->alpha, AlphaMixing::Linear);
    EXPECT_EQ(request->palette.inks.front().colour, (Colour{0x11, 0x22, 0x33}));
    EXPECT_TRUE(request->palette.paper.transparent);
    EXPECT_EQ(request->format->file.name, "json");
}

TEST(HalftoneOptions, NameInvalidOption) {
    const Options wrong = {{"sites", "0"},          {"sites", "12abc"},     {"seed", "9007199254740992"},
                           {"seed", "-1"},          {"iterations", "1001"}, {"passes", "0"},
                           {"passes", "101"},       {"scale", "0.05"},      {"scale", "17"},
                           {"scale", "nan"},        {"width", "0"},         {"width", "65536"},
                           {"width", "640.5"},      {"height", "0"},        {"height", "auto"},
                           {"fit", "fill"},         {"dot", "0"},           {"dot", "big"},
                           {"detail", "-0.1"},      {"detail", "1.1"},      {"dots", "none"},
                           {"invert", "2"},         {"antialias", "2"},     {"quality", "good"},
                           {"quality", "stealthy"}, {"tone", "loud"},       {"foreground", "transparent"},
                           {"background", ""},      {"format", "bmp"},      {"format", "geojson"},
                           {"sights", "10"},        {"image", "aGVsbG8="},  {"method", "ccdt"},
                           {"alpha", "none"}};
    for (const auto& option : wrong) {
        const auto request = parse({option});
        ASSERT_FALSE(request) << option.name << '=' << option.value;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed) << option.name;
        EXPECT_EQ(request.error().field, option.name);
    }
    EXPECT_EQ(parse({{"dot", "big"}}).error().message,
              "dot must be a number above 0, at most 65536, with or without mm, or auto");
    EXPECT_TRUE(parse({{"dot", "auto"}}));
}

TEST(HalftoneOptions, DistinguishScreenFromPrint) {
    const auto is_soft = [](const Options& options) {
        const auto request = parse(options);
        EXPECT_TRUE(request) << request.error().message;
        return request->antialias && request->on_screen;
    };
    for (const Options& options : {Options{},
                                   {{"format", "webp"}},
                                   {{"width", "640"}},
                                   {{"height", "480"}},
                                   {{"format", "tiff"}, {"width", "640"}},
                                   {{"dot", "3"}},
                                   {{"sites", "100"}}})
        EXPECT_TRUE(is_soft(options));
    for (const Options& options : {Options{{"scale", "2"}},
                                   {{"width_mm", "100"}},
                                   {{"width_mm", "100"}, {"width", "640"}},
                                   {{"format", "tiff"}},
                                   {{"format", "svg"}},
                                   {{"format", "json"}}})
        EXPECT_FALSE(is_soft(options));
    EXPECT_TRUE(parse({{"scale", "2"}, {"antialias", "true"}})->antialias);
    EXPECT_FALSE(parse({{"width", "640"}, {"antialias", "false"}})->antialias);
    EXPECT_FALSE(parse({{"antialias", "false"}})->antialias);
}

TEST(HalftoneOptions, RejectContradictorySizes) {
    struct Wrong {
        Options options;
        std::string field;
        std::string message;
    };
    for (const auto& [options, field, message] :
         {Wrong{{{"scale", "2"}, {"width", "640"}}, "width", "width replaces scale: give only one of them"},
          Wrong{{{"height", "640"}, {"scale", "2"}}, "height", "height replaces scale: give only one of them"},
          Wrong{{{"fit", "cover"}}, "fit", "fit needs width and height"},
          Wrong{{{"width", "9"}, {"height", "9"}, {"gravity", "0.5,0.1"}}, "gravity", "gravity needs fit=cover"},
          Wrong{{{"gravity", "0.5"}}, "gravity", "gravity must be two numbers from 0 to 1, such as 0.5,0.2"},
          Wrong{{{"gravity", "0.5,1.5"}}, "gravity", "gravity: value 2 must be a number from 0 to 1"},
          Wrong{{{"fit", "cover"}, {"width", "9"}}, "fit", "fit needs both width and height"},
          Wrong{{{"width", "9"}, {"format", "csv"}},
                "width",
                "width is an option of drawings only; lists of dots are in pixels of the picture"}}) {
        const auto request = parse(options);
        ASSERT_FALSE(request) << field;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, field);
        EXPECT_EQ(request.error().message, message);
    }
    const std::string image = R"({"image":")" + base64(fixture("rgba.png")) + '"';
    EXPECT_EQ(parse_halftone_json(image + R"(,"width":640,"scale":1})", {}, "", {}).error().field, "/width");
    EXPECT_EQ(parse_halftone_json(image + R"(,"width":640})", {}, "", {})->width, 640);
}

TEST(HalftoneOptions, ForbidDetailWithDensityTone) {
    EXPECT_EQ(parse({{"tone", "density"}})->detail, 0);
    EXPECT_EQ(parse({{"tone", "density"}, {"detail", "0"}})->detail, 0);
    EXPECT_EQ(parse({{"detail", "0.5"}, {"tone", "density"}}).error().field, "detail");
}

TEST(HalftoneOptions, ReadLevels) {
    EXPECT_EQ(parse({{"levels", "0.1,0.9"}})->levels, (Levels{0.1, 0.9, 1}));
    EXPECT_EQ(parse({{"levels", " 0, 1 ,2.5"}})->levels, (Levels{0, 1, 2.5}));
    const std::string image = R"({"image":")" + base64(fixture("rgba.png")) + '"';
    const auto parse_json = [&](const std::string& levels) {
        return parse_halftone_json(image + R"(,"levels":)" + levels + '}', {}, "", {});
    };
    EXPECT_EQ(parse_json("[0.1,0.9,1.2]")->levels, (Levels{0.1, 0.9, 1.2}));
    EXPECT_EQ(parse_json("\"0.1,0.9,1.2\"")->levels, (Levels{0.1, 0.9, 1.2}));
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"", "levels must be a black point and a white point, both from 0 to 1, and optionally gamma"},
        {"0.5", "levels must be a black point and a white point, both from 0 to 1, and optionally gamma"},
        {"0,1,1,1", "levels must be a black point and a white point, both from 0 to 1, and optionally gamma"},
        {"-0.1,1", "levels: black point must be a number from 0 to 1"},
        {"0,255", "levels: white point must be a number from 0 to 1"},
        {"0,1,0", "levels: gamma must be a number from 0.1 to 10"},
        {"0,1,nan", "levels: gamma must be a number from 0.1 to 10"},
        {"0.5,0.5", "levels must have a black point below the white point"}};
    for (const auto& [levels, message] : wrong) {
        const auto request = parse({{"levels", levels}});
        ASSERT_FALSE(request) << levels;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, "levels");
        EXPECT_EQ(request.error().message, message);
    }
    EXPECT_EQ(parse_json("[0,2]").error().field, "/levels/1");
    EXPECT_EQ(parse_json("[0,1,\"1\"]").error().field, "/levels/2");
    EXPECT_EQ(parse_json("7").error().field, "/levels");
}

TEST(HalftoneOptions, LimitNumberOfSites) {
    const auto request = parse({{"sites", "11"}}, "", {.max_sites = 10});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
}

TEST(HalftoneOptions, PreferFormatToAcceptHeader) {
    EXPECT_EQ(parse({}, "application/json")->format->file.name, "json");
    EXPECT_EQ(parse({{"format", "png"}}, "application/json")->format->file.name, "png");
    EXPECT_EQ(parse({{"format", "png"}}, "text/html")->format->file.name, "png");
    EXPECT_EQ(parse({}, "text/html").error().code, ErrorCode::NotAcceptable);
}

TEST(HalftoneRequest, RequiresImage) {
    EXPECT_EQ(parse_halftone("", {}, "", {}).error().code, ErrorCode::Malformed);
    EXPECT_EQ(parse_halftone("hello", {}, "", {}).error().code, ErrorCode::Unsupported);
}

TEST(HalftoneJson, ReadsImageAndOptions) {
    const std::string image = fixture("rgba.png");
    const std::string body =
        R"({"image":"data:image/png;base64,)" + base64(image) + R"(","sites":7,"invert":true,"dot":"auto","scale":2})";
    const auto request = parse_halftone_json(body, {{"seed", "3"}}, "", {});
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->image.bytes, image);
    EXPECT_EQ(request->sites, 7U);
    EXPECT_EQ(request->run.seed, 3U);
    EXPECT_EQ(request->scale, 2);
    EXPECT_EQ(request->dots, Dots::Paper);
}

TEST(HalftoneJson, PointsToInvalidMember) {
    const std::string image = R"("image":")" + base64(fixture("rgba.png")) + '"';
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {R"({"sites":7})", "/image"},
        {R"({"image":7})", "/image"},
        {R"({"image":"*"})", "/image"},
        {'{' + image + R"(,"sites":"7"})", "/sites"},
        {'{' + image + R"(,"sites":7.5})", "/sites"},
        {'{' + image + R"(,"invert":1})", "/invert"},
        {'{' + image + R"(,"a/b":1})", "/a~1b"},
        {"[]", ""},
        {"", ""},
    };
    for (const auto& [body, field] : wrong) {
        const auto request = parse_halftone_json(body, {}, "", {});
        ASSERT_FALSE(request) << body;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, field);
    }
    const auto twice = parse_halftone_json('{' + image + R"(,"sites":7})", {{"sites", "7"}}, "", {});
    ASSERT_FALSE(twice);
    EXPECT_EQ(twice.error().message, "sites is given twice");
}

TEST(Halftone, PreservesMeanTone) {
    constexpr double kExpected = 0.373205;
    for (const auto* dots : {"both", "ink", "paper"}) {
        const auto result = answer(fixture("lossless.webp"), {{"sites", "200"}, {"scale", "16"}, {"dots", dots}});
        ASSERT_TRUE(result) << result.error().message;
        EXPECT_EQ(result->media_type, "image/png");
        const DecodedPng png = decode_png(result->body);
        EXPECT_EQ(png.width, 24 * 16);
        EXPECT_EQ(png.height, 16 * 16);
        EXPECT_EQ(png.bit_depth, 1);
        EXPECT_NEAR(white_share(png), kExpected, 0.01) << dots;
    }
}

TEST(Halftone, PlacesDotsInDarkParts) {
    const auto result = answer(fixture("lossless.webp"), {{"sites", "1000"}, {"format", "json"}, {"tone", "density"}});
    ASSERT_TRUE(result);
    EXPECT_EQ(result->media_type, "application/json");
    const auto json = nlohmann::json::parse(result->body);
    EXPECT_EQ(json.at("width"), 24);
    EXPECT_EQ(json.at("height"), 16);
    ASSERT_EQ(json.at("points").size(), 1000U);
    std::array<std::array<int, 2>, 2> counts{};
    for (const auto& point : json.at("points")) {
        const double x = point[0];
        const double y = point[1];
        ASSERT_TRUE(x > 0 && x < 24 && y > 0 && y < 16);
        ++counts[y < 8 ? 0 : 1][x < 12 ? 0 : 1];
    }
    EXPECT_NEAR(counts[0][0], 1000 * 1 / 2.5072, 40);
    EXPECT_NEAR(counts[0][1], 1000 * (1 - 0.0908) / 2.5072, 40);
    EXPECT_NEAR(counts[1][0], 1000 * (1 - 0.4020) / 2.5072, 40);
    EXPECT_LT(counts[1][1], 5);
}

TEST(Halftone, IsReproducibleForSeed) {
    const std::string image = fixture("lossless.webp");
    const Options options = {{"sites", "50"}, {"seed", "1"}};
    EXPECT_EQ(answer(image, options)->body, answer(image, options)->body);
    EXPECT_NE(answer(image, options)->body, answer(image, {{"sites", "50"}, {"seed", "2"}})->body);
}

TEST(Halftone, UsesGivenColours) {
    const auto result = answer(fixture("lossless.webp"), {{"sites", "50"},
                                                          {"scale", "8"},
                                                          {"invert", "true"},
                                                          {"antialias", "true"},
                                                          {"foreground", "#306"},
                                                          {"background", "transparent"}});
    ASSERT_TRUE(result);
    const DecodedPng png = decode_png(result->body);
    int partly = 0;
    for (const auto& pixel : png.pixels) {
        ASSERT_TRUE(pixel[0] == 0x33 && pixel[1] == 0 && pixel[2] == 0x66);
        partly += pixel[3] > 0 && pixel[3] < 255 ? 1 : 0;
    }
    EXPECT_GT(partly, 0);
}

TEST(Halftone, ChoosesSitesAndScaleFromPicture) {
    const auto result = answer(photograph("chelsea.png"), {{"width_mm", "100"}});
    ASSERT_TRUE(result);
    const DecodedPng png = decode_png(result->body);
    EXPECT_GE(png.width, 451);
    EXPECT_EQ(std::lround(png.width / 451.0 * 300), png.height);
    EXPECT_EQ(png.bit_depth, 1);
}

TEST(Halftone, DrawsForScreenByDefault) {
    const std::string photo = photograph("chelsea.png");
    for (const auto* color : {"gray", "cmyk"}) {
        const auto result = answer(photo, {{"color", color}, {"quality", "draft"}});
        ASSERT_TRUE(result) << result.error().message;
        const DecodedPng png = decode_png(result->body);
        EXPECT_EQ(png.width, 1203);
        EXPECT_EQ(png.height, 800);
        EXPECT_EQ(png.bit_depth, 8);
    }
}

TEST(Halftone, HasRequestedSize) {
    const std::string photo = photograph("chelsea.png");
    struct Size {
        Options options;
        int width, height;
    };
    for (const auto& [options, width, height] :
         {Size{{{"width", "137"}}, 137, 91}, Size{{{"height", "137"}}, 206, 137},
          Size{{{"width", "137"}, {"height", "50"}}, 75, 50},
          Size{{{"width", "137"}, {"height", "50"}, {"fit", "cover"}}, 137, 50},
          Size{{{"width", "50"}, {"height", "137"}, {"fit", "cover"}, {"color", "cmyk"}}, 50, 137},
          Size{{{"width", "1"}}, 1, 1}, Size{{{"width", "137"}, {"width_mm", "10"}}, 137, 91},
          Size{{{"width", "137"}, {"antialias", "false"}}, 137, 91}}) {
        Options asked = options;
        asked.push_back({"quality", "draft"});
        const auto result = answer(photo, asked);
        ASSERT_TRUE(result) << result.error().message;
        const DecodedPng png = decode_png(result->body);
        EXPECT_EQ(png.width, width);
        EXPECT_EQ(png.height, height);
    }
    const auto drawing = answer(photo, {{"width", "137"}, {"format", "svg"}});
    EXPECT_NE(drawing->body.find(R"(width="137" height="91")"), std::string::npos);
}

TEST(Halftone, LimitsPixelsOfRequestedSize) {
    const Limits limits = {.max_pixels = 10'000};
    const std::string image = fixture("lossless.webp");
    const auto large = answer(image, {{"sites", "50"}, {"height", "101"}}, limits);
    ASSERT_FALSE(large);
    EXPECT_EQ(large.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(large.error().field, "height");
    EXPECT_EQ(large.error().message,
              "height makes an output of 152 x 101 pixels; this server's limit (max-pixels) is 10000");
    EXPECT_TRUE(answer(image, {{"sites", "50"}, {"height", "81"}}, limits));
    EXPECT_EQ(answer(image, {{"sites", "50"}, {"width", "60000"}, {"height", "60000"}}, limits).error().field, "width");
    const auto webp = answer(image, {{"sites", "50"}, {"width", "16384"}, {"format", "webp"}}, {});
    EXPECT_EQ(webp.error().field, "width");
}

TEST(Halftone, CropsToMiddleIfFitIsCover) {
    // White, with a black square in the middle. The square is narrow enough to stay whole after cropping.
    Raster raster{300, 100, 1, std::vector<std::uint8_t>(std::size_t{300} * 100)};
    for (int y = 25; y < 75; ++y) {
        for (int x = 125; x < 175; ++x) raster.coverage[static_cast<std::size_t>(y * 300 + x)] = 255;
    }
    const std::string image = *write_png(image_of(raster, false));
    const auto result = answer(image, {{"width", "100"}, {"height", "100"}, {"fit", "cover"}});
    ASSERT_TRUE(result) << result.error().message;
    const DecodedPng png = decode_png(result->body);
    EXPECT_EQ(png.at(50, 50)[0], 0);
    for (const int at : {28, 71}) {
        EXPECT_LT(png.at(at, 50)[0], 30);
        EXPECT_LT(png.at(50, at)[0], 30);
    }
    for (const int at : {21, 78}) {
        EXPECT_GT(png.at(at, 50)[0], 225);
        EXPECT_GT(png.at(50, at)[0], 225);
    }
}

TEST(Halftone, DrawsAtLeastOnePixel) {
    const auto result = answer(fixture("palette-transparent.png"), {{"scale", "0.1"}, {"sites", "1"}});
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(decode_png(result->body).width, 1);
    EXPECT_EQ(decode_png(result->body).height, 1);
}

TEST(Halftone, LimitsPixelsOfScaledDrawing) {
    const Limits limits = {.max_pixels = std::size_t{24} * 16 * 9};
    const auto large = answer(fixture("lossless.webp"), {{"sites", "50"}, {"scale", "4"}}, limits);
    ASSERT_FALSE(large);
    EXPECT_EQ(large.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(large.error().field, "scale");
    EXPECT_NE(large.error().message.find("96 x 64"), std::string::npos);
    EXPECT_TRUE(answer(fixture("lossless.webp"), {{"sites", "50"}, {"scale", "3"}}, limits));
    EXPECT_TRUE(answer(fixture("lossless.webp"), {{"sites", "5000"}}, limits)) << "the default scale is reduced";
    EXPECT_TRUE(answer(fixture("lossless.webp"), {{"sites", "50"}, {"scale", "4"}, {"format", "json"}}, limits));
}

TEST(Halftone, RejectsPicturesWithoutInk) {
    const Raster paper{8, 8, 0, std::vector<std::uint8_t>(64, 0)};
    const std::string white = *write_png(image_of(paper, false));
    const std::string nothing = *write_png(image_of(paper, false, kBlack, {.transparent = true}));
    for (const auto& image : {white, nothing}) {
        const auto result = answer(image, {});
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_NE(result.error().message.find("white"), std::string::npos);
    }
    EXPECT_TRUE(answer(white, {{"invert", "true"}}));
    for (const Options& options : {Options{{"color", "cmyk"}}, Options{{"palette", "#f00,#fff"}}}) {
        const auto result = answer(white, options);
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::Unusable);
        EXPECT_NE(result.error().message.find("like its paper"), std::string::npos);
    }
    EXPECT_TRUE(answer(white, {{"color", "rgb"}}));
}

TEST(Halftone, DrawsBlackAndWhiteWithoutDots) {
    const std::string black = *write_png(image_of({8, 8, 0, std::vector<std::uint8_t>(64, 255)}, false));
    for (const auto* sites : {"1", "50"}) {
        const auto drawn = answer(black, {{"sites", sites}, {"scale", "2"}});
        ASSERT_TRUE(drawn) << drawn.error().message;
        EXPECT_EQ(drawn->sites, 0U);
        EXPECT_EQ(white_share(decode_png(drawn->body)), 0);
    }
    const auto listed = nlohmann::json::parse(answer(black, {{"format", "json"}, {"dots", "both"}})->body);
    EXPECT_EQ(listed.at("sites"), 0);
    EXPECT_TRUE(listed.at("points").empty());
    EXPECT_EQ(listed.at("rings"), nlohmann::json::parse("[[[0,0],[0,8],[8,8],[8,0]]]"));
    const auto table = answer(black, {{"format", "csv"}, {"dots", "both"}});
    EXPECT_EQ(table->body, "x,y\r\n");
}

/// Returns the area that rings enclose.
double area_of(const nlohmann::json& rings) {
    double twice = 0;
    for (const auto& ring : rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const auto &a = ring[i], &b = ring[(i + 1) % ring.size()];
            twice += a[0].get<double>() * b[1].get<double>() - a[1].get<double>() * b[0].get<double>();
        }
    }
    return std::abs(twice) / 2;
}

TEST(Halftone, ListsOutlinesOfInk) {
    const std::string photo = photograph("camera.png");
    const auto list = [&](const char* format, const char* color) {
        return answer(photo, {{"sites", "700"}, {"dots", "both"}, {"format", format}, {"color", color}})->body;
    };
    const auto json = nlohmann::json::parse(list("json", "gray"));
    ASSERT_EQ(json.at("points").size(), 700U);
    std::string table = "x,y\r\n";
    for (const auto& point : json.at("points")) {
        append_shortest(table, point[0].get<double>());
        table += ',';
        append_shortest(table, point[1].get<double>());
        table += "\r\n";
    }
    EXPECT_TRUE(list("csv", "gray") == table) << "CSV must have the same numbers";
    const double white = white_share(decode_png(answer(photo, {{"sites", "700"}, {"scale", "4"}})->body));
    const double all = json.at("width").get<double>() * json.at("height").get<double>();
    EXPECT_NEAR(1 - area_of(json.at("rings")) / all, white, 0.003);

    const auto inks = nlohmann::json::parse(list("json", "cmyk"));
    EXPECT_EQ(inks.at("points").size(), 700U);
    ASSERT_EQ(inks.at("inks").size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(inks.at("inks")[i].at("name"), (std::array{"cyan", "magenta", "yellow"})[i]);
        EXPECT_NEAR(area_of(inks.at("inks")[i].at("rings")), area_of(json.at("rings")), 0.003 * all)
            << "a grey picture";
    }
}

const PointFormat& format_named(std::string_view name) {
    return **std::ranges::find(halftone_formats(), name, [](const PointFormat* each) { return each->file.name; });
}

/// Places the dots of a request, and writes them in another format.
Result<Answer> write_as(std::string_view format, const std::string& image, const Options& options) {
    const auto request = *parse_halftone(image, options, "", {});
    Timings timings;
    const auto placed = *place_halftone(request, {}, decode_inline(), {}, timings);
    return write_answer(request, placed, format_named(format), {}, {}, timings);
}

TEST(PlacedHalftone, HasTheSameDotsInAllFormats) {
    const std::string photo = photograph("camera.png");
    const Options options = {{"sites", "300"}, {"dots", "both"}, {"scale", "2"}, {"antialias", "true"}};
    for (const char* format : {"svg", "csv", "npy", "tiff"}) {
        Options direct = options;
        direct.push_back({"format", format});
        EXPECT_TRUE(write_as(format, photo, options)->body == answer(photo, direct)->body) << format;
    }
}

TEST(PlacedHalftone, RejectsFormatsThatCannotDrawIt) {
    const auto check = [](std::string_view format, const Options& options, ErrorCode code, const std::string& field) {
        const auto written = write_as(format, photograph("camera.png"), options);
        ASSERT_FALSE(written) << format;
        EXPECT_EQ(written.error().code, code) << written.error().message;
        EXPECT_EQ(written.error().field, field);
    };
    check("gcode", {{"sites", "50"}, {"width_mm", "50"}}, ErrorCode::Malformed, "dots");
    check("pdf", {{"sites", "50"}}, ErrorCode::Malformed, "width_mm");
    check("png", {{"sites", "50"}, {"scale", "16"}, {"format", "json"}}, ErrorCode::LimitExceeded, "scale");
}

TEST(PlacedHalftone, KeepsThePathsThatLimitTheTime) {
    const std::string photo = photograph("camera.png");
    const auto request = *parse_halftone(photo, {{"minutes", "4"}, {"width_mm", "90"}}, "", {});
    Timings timings;
    const auto placed = *place_halftone(request, {}, decode_inline(), {}, timings);
    ASSERT_EQ(placed.plan.paths.size(), 1U);
    EXPECT_EQ(placed.plan.paths.front().size(), placed.dots.front().points.size());
}

TEST(HalftoneOptions, ChooseSidesOfDots) {
    const auto dots = [](const Options& options) { return parse(options)->dots; };
    for (const auto* drawn : {"png", "webp", "jpeg", "tiff", "svg"})
        EXPECT_EQ(dots({{"format", drawn}}), Dots::Both) << drawn;
    EXPECT_EQ(dots({{"format", "pdf"}, {"width_mm", "90"}}), Dots::Both);
    for (const auto* plotted : {"hpgl", "gcode", "dxf"})
        EXPECT_EQ(dots({{"format", plotted}, {"width_mm", "90"}}), Dots::Ink) << plotted;
    EXPECT_EQ(dots({{"minutes", "9"}, {"width_mm", "90"}}), Dots::Ink);
    for (const auto* list : {"json", "csv", "npy"}) {
        EXPECT_EQ(dots({{"format", list}}), Dots::Ink) << list;
        EXPECT_EQ(dots({{"format", list}, {"dots", "both"}}), Dots::Both) << list;
    }
    for (const Options& options : {Options{{"style", "stroke"}, {"format", "svg"}},
                                   {{"tone", "density"}},
                                   {{"palette", "#f00"}, {"format", "csv"}},
                                   {{"color", "cmyk"}, {"format", "json"}},
                                   {{"invert", "false"}}})
        EXPECT_EQ(dots(options), Dots::Ink);
    EXPECT_EQ(dots({{"background", "transparent"}}), Dots::Both);
    EXPECT_EQ(dots({{"background", "transparent"}, {"format", "svg"}}), Dots::Both);
    EXPECT_EQ(dots({{"palette", "#f00,#0f0,#00f,#000,#ff0,#0ff"}}), Dots::Both);
    EXPECT_EQ(dots({{"color", "cmyk"}}), Dots::Both);
    EXPECT_EQ(dots({{"palette", "#f00,#00f"}}), Dots::Both);
    EXPECT_EQ(dots({{"color", "rgb"}, {"dots", "ink"}}), Dots::Ink);
    EXPECT_EQ(dots({{"color", "rgb"}, {"dots", "both"}, {"format", "npy"}}), Dots::Both);
    EXPECT_EQ(dots({{"invert", "true"}}), Dots::Paper);
    EXPECT_EQ(dots({{"dots", "paper"}}), Dots::Paper);
    EXPECT_EQ(dots({{"dots", "paper"}, {"invert", "true"}}), Dots::Paper);
    EXPECT_EQ(dots({{"dots", "both"}, {"invert", "false"}}), Dots::Both);
}

TEST(HalftoneOptions, RejectUnsupportedSidesOfDots) {
    const std::vector<std::pair<Options, std::string>> wrong = {
        {{{"dots", "paper"}, {"color", "cmyk"}}, "dots"},
        {{{"dots", "both"}, {"palette", "#f00"}, {"style", "stroke"}, {"format", "svg"}}, "dots"},
        {{{"dots", "paper"}, {"palette", "#f00"}}, "dots"},
        {{{"dots", "both"}, {"tone", "density"}}, "dots"},
        {{{"dots", "both"}, {"style", "stroke"}, {"format", "svg"}}, "dots"},
        {{{"dots", "both"}, {"format", "dxf"}, {"width_mm", "90"}}, "dots"},
        {{{"dots", "both"}, {"minutes", "9"}, {"width_mm", "90"}}, "dots"},
        {{{"sites", "50"}, {"dot", "2"}}, "dot"},
        {{{"dots", "both"}, {"invert", "true"}}, "invert"},
        {{{"dots", "ink"}, {"invert", "true"}}, "invert"},
        {{{"dots", "paper"}, {"invert", "false"}}, "invert"},
    };
    for (const auto& [options, field] : wrong) {
        const auto request = parse(options);
        ASSERT_FALSE(request) << field;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed) << field;
        EXPECT_EQ(request.error().field, field);
    }
}

TEST(HalftoneOptions, OfAPenGiveTheRadiusOfStrokes) {
    const auto strokes = parse({{"style", "stroke"}, {"pen", "0.5"}, {"width_mm", "90"}});
    ASSERT_TRUE(strokes && strokes->dot);
    EXPECT_EQ(strokes->dot->length, 0.25);
    EXPECT_TRUE(strokes->dot->millimetres);
    EXPECT_FALSE(parse({{"style", "spiral"}, {"pen", "0.5"}, {"width_mm", "90"}})->dot);
}

TEST(HalftoneOptions, WithoutEffectAreRejected) {
    const std::vector<std::pair<Options, std::string>> wrong = {
        {{{"pen", "0.5"}}, "pen"},
        {{{"pen", "0.5"}, {"format", "gcode"}, {"width_mm", "90"}}, "pen"},
        {{{"pen", "0.5"}, {"style", "stroke"}}, "pen"},
        {{{"pen", "0.5"}, {"style", "stroke"}, {"dot", "2"}, {"width_mm", "90"}}, "dot"},
        {{{"pen", "0.5"}, {"style", "path"}, {"dot", "2"}, {"width_mm", "90"}}, "dot"},
        {{{"speed", "50"}}, "speed"},
        {{{"pen_up", "M5"}}, "pen_up"}};
    for (const auto& [options, field] : wrong) {
        const auto request = parse(options);
        ASSERT_FALSE(request) << field;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed) << field;
        EXPECT_EQ(request.error().field, field);
    }
}

TEST(HalftoneOptions, HaveLengthsWithUnits) {
    EXPECT_EQ(parse({{"width_mm", "20cm"}})->drawing.width_mm, 200);
    EXPECT_EQ(parse({{"width_mm", "10in"}})->drawing.width_mm, 254);
    EXPECT_EQ(parse({{"width_mm", "9mm"}})->drawing.width_mm, 9);
    for (const char* wrong : {"cm", "1001cm", "9m", "0.05cm"}) EXPECT_FALSE(parse({{"width_mm", wrong}})) << wrong;
}

TEST(HalftoneOptions, OfPlottersHaveTheirDefaultsAndLimits) {
    const auto usual = parse({});
    EXPECT_EQ(usual->drawing.pen_mm, 0.3);
    EXPECT_EQ(usual->drawing.plotter.speed, 100);
    EXPECT_EQ(usual->drawing.plotter.pause(), 0.075);
    EXPECT_EQ(usual->drawing.plotter.pen_down, "");
    EXPECT_EQ(parse({{"style", "path"}, {"pen", "0.5mm"}})->drawing.pen_mm, 0.5);
    EXPECT_EQ(parse({{"pen_up", "G0 Z2|S0"}, {"width_mm", "90"}})->drawing.plotter.pen_up, "G0 Z2|S0");
    const std::vector<Options> wrong = {{{"pen", "0.001"}},
                                        {{"pen", "1e308"}},
                                        {{"pen", "1e-308mm"}},
                                        {{"speed", "0"}},
                                        {{"dwell", "-1"}},
                                        {{"pen_up", ""}},
                                        {{"pen_down", "M3;"}},
                                        {{"pen_down", "M3\nM5"}},
                                        {{"pen_up", std::string(65, 'M')}},
                                        {{"pen_up", "$$"}},
                                        {{"minutes", "0"}},
                                        {{"minutes", "9"}},
                                        {{"minutes", "9"}, {"width_mm", "90"}, {"sites", "9"}}};
    for (const Options& options : wrong) {
        const auto request = parse(options);
        ASSERT_FALSE(request) << options.front().name;
        EXPECT_EQ(request.error().field, options.front().name);
    }
    for (const auto* format : {"pdf", "eps", "hpgl", "gcode", "dxf"}) {
        const auto request = parse({{"format", format}});
        ASSERT_FALSE(request) << format;
        EXPECT_EQ(request.error().field, "width_mm");
    }
}

TEST(HalftoneOptions, MeasureDotsInPixelsOrMillimetres) {
    EXPECT_FALSE(parse({{"dot", "2"}})->dot->millimetres);
    const auto pen = parse({{"dot", "0.4mm"}, {"width_mm", "150"}});
    EXPECT_TRUE(pen->dot->millimetres);
    EXPECT_EQ(pen->dot->length, 0.4);
    EXPECT_NE(parse({{"dot", "0.4mm"}}).error().message.find("width_mm"), std::string::npos);
    for (const auto* wrong : {"0mm", "mm", "0.4cm", "-1mm", "0.4 mm"}) {
        const auto request = parse({{"dot", wrong}, {"width_mm", "150"}});
        ASSERT_FALSE(request) << wrong;
        EXPECT_EQ(request.error().field, "dot");
    }
}

/// Returns the answer in JSON.
nlohmann::json dots_of(const Options& options) {
    Options asked = options;
    asked.push_back({"format", "json"});
    return nlohmann::json::parse(answer(photograph("camera.png"), asked)->body);
}

TEST(Halftone, DerivesNumberOfDotsFromPenWidth) {
    const auto fine = dots_of({{"dot", "0.4mm"}, {"width_mm", "150"}, {"iterations", "1"}, {"quality", "draft"}});
    const auto broad = dots_of({{"dot", "0.8mm"}, {"width_mm", "150"}, {"iterations", "1"}, {"quality", "draft"}});
    EXPECT_NEAR(fine.at("radius").get<double>(), 0.4 / 150 * 512, 1e-9);
    EXPECT_NEAR(fine.at("sites").get<double>() / broad.at("sites").get<double>(), 4, 0.1);
    for (const auto& each : {fine, broad}) EXPECT_NEAR(each.at("tone").get<double>(), 1, 0.001);
    const auto pixels = dots_of({{"dot", "4"}, {"scale", "2"}, {"iterations", "1"}, {"quality", "draft"}});
    EXPECT_EQ(pixels.at("radius"), 2);
    const auto again = dots_of({{"sites", std::to_string(pixels.at("sites").get<int>())}, {"iterations", "1"}});
    EXPECT_NEAR(again.at("radius").get<double>(), 2, 0.001) << "radius and number must determine each other";
}

TEST(Halftone, ReportsToneForGivenNumberAndSizeOfDots) {
    const auto light = dots_of({{"dot", "2"}, {"scale", "2"}, {"sites", "5000"}, {"iterations", "1"}});
    EXPECT_EQ(light.at("radius"), 1);
    EXPECT_LT(light.at("tone").get<double>(), 0.2);
    EXPECT_EQ(light.at("sites"), 5000);
    EXPECT_FALSE(dots_of({{"sites", "500"}, {"tone", "density"}}).contains("tone"));
    const auto refused = answer(photograph("camera.png"), {{"dot", "0.5"}, {"scale", "4"}}, {.max_sites = 10'000});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(refused.error().field, "dot");
}

TEST(HalftoneOptions, ChooseInks) {
    const auto palette = [](const Options& options) { return parse(options)->palette; };
    EXPECT_EQ(palette({{"color", "gray"}}).mixing, Mixing::Cover);
    EXPECT_EQ(palette({{"color", "cmyk"}}).inks.size(), 4U);
    EXPECT_EQ(palette({{"color", "rgb"}}).mixing, Mixing::Add);
    EXPECT_EQ(palette({{"color", "cmyk"}, {"background", "#ffe"}}).paper, (Colour{255, 255, 0xee}));
    EXPECT_EQ(palette({{"palette", "#f00,#00f"}, {"background", "transparent"}}).paper.transparent, true);
    EXPECT_EQ(palette({{"palette", "#f00,#00f"}, {"invert", "false"}}).mixing, Mixing::Multiply);
}

TEST(HalftoneOptions, SetForegroundAndBackground) {
    const auto colours = [](const Options& options) {
        const Palette palette = parse(options)->palette;
        return std::pair(palette.inks.at(0).colour, palette.paper);
    };
    EXPECT_EQ(colours({{"invert", "true"}}), std::pair(kWhite, kBlack));
    EXPECT_EQ(colours({{"invert", "true"}, {"foreground", "#f00"}}), std::pair(Colour{255, 0, 0}, kBlack));
    EXPECT_EQ(colours({{"color", "gray"}, {"background", "#00f"}}), std::pair(kBlack, Colour{0, 0, 255}));
}

TEST(HalftoneOptions, RejectContradictoryInks) {
    const std::vector<std::pair<Options, std::string>> wrong = {
        {{{"color", "CMYK"}}, "color"},
        {{{"palette", "#f00,#f00"}}, "palette"},
        {{{"palette", "#f00"}, {"color", "cmyk"}}, "palette"},
        {{{"color", "gray"}, {"palette", "#f00"}}, "palette"},
        {{{"color", "cmyk"}, {"foreground", "#f00"}}, "foreground"},
        {{{"invert", "true"}, {"palette", "#f00"}}, "invert"},
        {{{"color", "rgb"}, {"background", "#000"}}, "background"},
    };
    for (const auto& [options, field] : wrong) {
        const auto request = parse(options);
        ASSERT_FALSE(request) << field;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed) << field;
        EXPECT_EQ(request.error().field, field);
    }
    const std::string image = R"("image":")" + base64(fixture("rgba.png")) + '"';
    EXPECT_EQ(parse_halftone_json('{' + image + R"(,"palette":["#f00"],"invert":true})", {}, "", {}).error().field,
              "/invert");
}

/// Returns the mean light of each channel.
std::array<double, 3> mean_light(const ColourPicture& picture) {
    std::array<double, 3> mean{};
    const std::array<const Plane*, 3> planes = {&picture.red, &picture.green, &picture.blue};
    for (std::size_t i = 0; i < 3; ++i) {
        for (const float light : *planes[i]) mean[i] += static_cast<double>(light);
        mean[i] /= static_cast<double>(planes[i]->size());
    }
    return mean;
}

TEST(Halftone, PreservesMeanColour) {
    constexpr std::size_t kMaxPixels = 16'000'000;
    const std::string photo = photograph("chelsea.png");
    const auto wanted = mean_light(*decode_colour_image(photo, kMaxPixels));
    for (const auto* color : {"cmyk", "rgb"}) {
        // In the last case, dots are so large that densities have cells of several pixels.
        for (const auto& [sites, antialias] : {std::pair("8000", "false"), {"8000", "true"}, {"600", "true"}}) {
            const auto result =
                answer(photo, {{"sites", sites}, {"scale", "4"}, {"color", color}, {"antialias", antialias}});
            ASSERT_TRUE(result) << result.error().message;
            EXPECT_EQ(std::to_string(result->sites), sites);
            const auto seen = mean_light(*decode_colour_image(result->body, kMaxPixels));
            for (std::size_t i = 0; i < 3; ++i)
                EXPECT_NEAR(seen[i], wanted[i], 0.03) << color << sites << antialias << i;
        }
    }
}

TEST(Halftone, ListsDotsOfEachInk) {
    const Options options = {{"sites", "700"}, {"palette", "#c00,#00c"}, {"format", "json"}};
    const auto json = nlohmann::json::parse(answer(photograph("chelsea.png"), options)->body);
    EXPECT_FALSE(json.contains("points"));
    EXPECT_EQ(json.at("sites"), 700);
    ASSERT_EQ(json.at("inks").size(), 2U);
    std::size_t sites = 0;
    for (const auto& ink : json.at("inks")) {
        sites += ink.at("points").size();
        EXPECT_EQ(ink.at("points").size(), ink.at("sites"));
        EXPECT_EQ(ink.at("name"), ink.at("color"));
    }
    EXPECT_EQ(sites, 700U);
}

/// Compares the numbers of points of two lists in squares of 64 pixels, and returns the sum of the absolute differences
/// over the number of points. Single points differ because densities differ in their last digits.
double difference(const nlohmann::json& points, const nlohmann::json& others) {
    constexpr double kPart = 64;  // pixels
    std::map<std::pair<int, int>, int> excess;
    const auto count = [&](const nlohmann::json& list, int step) {
        for (const auto& point : list)
            excess[{static_cast<int>(point[0].get<double>() / kPart),
                    static_cast<int>(point[1].get<double>() / kPart)}] += step;
    };
    count(points, 1);
    count(others, -1);
    double sum = 0;
    for (const auto& [part, more] : excess) sum += std::abs(more);
    return sum / static_cast<double>(points.size());
}

TEST(Halftone, PlacesDotsOfBlackInkLikeThoseOfGrey) {
    const std::string photo = photograph("camera.png");
    const auto points = [&](Options options) {
        options.insert(options.end(), {{"sites", "9000"}, {"seed", "5"}, {"format", "json"}});
        return nlohmann::json::parse(answer(photo, options)->body);
    };
    const auto grey = points({});
    EXPECT_LT(difference(points({{"palette", "#000"}}).at("inks").at(0).at("points"), grey.at("points")), 0.03);
    const auto cmyk = points({{"color", "cmyk"}}).at("inks");
    EXPECT_LT(difference(cmyk.at(3).at("points"), grey.at("points")), 0.03);
    EXPECT_EQ(cmyk.at(0).at("sites"), 0);
}

TEST(Halftone, ReportsBrokenImages) {
    const std::string image = photograph("camera.png");
    const auto result = answer(image.substr(0, image.size() / 2), {});
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Unusable);
}

TEST(Halftone, StopsOnRequest) {
    std::stop_source stop;
    const std::string file = fixture("lossless.webp");
    const auto request = parse_halftone(file, {{"sites", "50"}}, "", {});
    Timings timings;
    Control control{stop.get_token(), [&](const Progress&) { stop.request_stop(); }};
    const auto result = run_halftone(*request, {}, decode_inline(), control, timings);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::Stopped);
}

TEST(Halftone, StopsOnRequestInColour) {
    const std::string file = photograph("chelsea.png");
    for (const auto& [on_deadline, may_answer] : {std::pair{"error", false}, {"partial", true}}) {
        std::stop_source stop;
        const auto request =
            parse_halftone(file, {{"sites", "500"}, {"color", "cmyk"}, {"on_deadline", on_deadline}}, "", {});
        Timings timings;
        Control control{stop.get_token(), [&](const Progress&) { stop.request_stop(); }};
        const auto result = run_halftone(*request, {}, decode_inline(), control, timings);
        ASSERT_EQ(result.has_value(), may_answer);
        if (may_answer) {
            EXPECT_TRUE(result->partial);
            EXPECT_EQ(result->sites, 500U);
        } else {
            EXPECT_EQ(result.error().code, ErrorCode::Stopped);
        }
    }
}

TEST(Halftone, ReportsMonotonicProgress) {
    double done = 0;
    int iteration = 0;
    const std::string file = photograph("chelsea.png");
    const auto request = parse_halftone(file, {{"sites", "500"}, {"color", "rgb"}}, "", {});
    Timings timings;
    Control control{{}, [&](const Progress& progress) {
                        EXPECT_GT(progress.done(), done);
                        EXPECT_EQ(progress.iterations, 5);
                        done = progress.done();
                        iteration = progress.iteration;
                    }};
    ASSERT_TRUE(run_halftone(*request, {}, decode_inline(), control, timings));
    EXPECT_EQ(iteration, 5);
    EXPECT_GT(done, 0.85);
    EXPECT_LT(done, 1);
}

}  // namespace
}  // namespace ccdt::api
