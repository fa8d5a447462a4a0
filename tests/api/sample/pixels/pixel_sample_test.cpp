// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/pixels/pixel_sample.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "api/image/png_writer.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

constexpr const char* kRaster = R"("domain":{"type":"pixels","width":16,"height":12})";

/// @param members  members of the body in addition to the domain
Result<PixelRequest> parse(const std::string& members, const std::string& domain = kRaster, const Limits& limits = {}) {
    const auto document = JsonDocument::parse('{' + domain + ',' + members + '}');
    if (!document) return tl::unexpected(document.error());
    EXPECT_TRUE(asks_for_pixels(document->root()));
    return parse_pixels(document->root(), {}, "", limits);
}

Result<Answer> answer(const std::string& members, const Control& control = {}) {
    const auto request = parse(members);
    if (!request) return tl::unexpected(request.error());
    Timings timings;
    return run_pixels(*request, {}, decode_inline(), control, timings);
}

using Points = std::vector<std::array<int, 2>>;

Points points(const std::string& members) {
    const auto made = answer(members);
    if (!made) ADD_FAILURE() << made.error().message;
    return nlohmann::json::parse(made->body).at("points").get<Points>();
}

/// Returns the fields of an error and its further errors, with commas between them.
std::string fields(const Result<PixelRequest>& request) {
    if (request) return "none";
    std::string all = request.error().field;
    for (const Error& other : request.error().others) all += ',' + other.field;
    return all;
}

TEST(PixelSample, HasTheSameSetInAllFormats) {
    constexpr std::size_t kWidth = 16, kHeight = 12;
    const Points list = points(R"("sites":40,"seed":3)");
    ASSERT_EQ(list.size(), 40U);
    std::string csv = "x,y\r\n", mask(kWidth * kHeight, '\0');
    for (const auto& [x, y] : list) {
        csv += std::to_string(x) + ',' + std::to_string(y) + "\r\n";
        mask[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)] = '\1';
    }
    EXPECT_EQ(answer(R"("sites":40,"seed":3,"format":"csv")")->body, csv);
    const std::string npy = answer(R"("sites":40,"seed":3,"format":"npy")")->body;
    EXPECT_EQ(npy.substr(npy.size() - mask.size()), mask);
    EXPECT_NE(npy.find("'descr': '|b1', 'fortran_order': False, 'shape': (12, 16)"), std::string::npos);
    EXPECT_EQ((npy.size() - mask.size()) % 64, 0U);
    const DecodedPng png = decode_png(answer(R"("sites":40,"seed":3,"format":"png")")->body);
    EXPECT_EQ(png.bit_depth, 1);
    ASSERT_EQ(png.pixels.size(), mask.size());
    for (std::size_t i = 0; i < mask.size(); ++i) EXPECT_EQ(png.pixels[i][0], mask[i] == '\1' ? 255 : 0);
}

TEST(PixelSample, HasTheCalibrationAreaInTheMiddle) {
    const auto calibrated = [](const std::string& calibration) {
        const auto request = parse(R"("sites":150,"calibration":)" + calibration);
        const CellBlock& block = request->included.at(0);
        return std::array{block.left, block.right, block.low, block.high};
    };
    EXPECT_EQ(calibrated(R"({"width":4,"height":2})"), (std::array{6, 10, 5, 7}));
    // The middle pixel is (8, 6), as after a shift of frequency 0 to the middle.
    EXPECT_EQ(calibrated(R"({"width":1,"height":1})"), (std::array{8, 9, 6, 7}));
    EXPECT_EQ(calibrated(R"({"width":3,"height":5})"), (std::array{7, 10, 4, 9}));
    EXPECT_EQ(calibrated(R"({"height":3})"), (std::array{0, 16, 5, 8}));
    EXPECT_EQ(calibrated(R"({"width":16})"), (std::array{0, 16, 0, 12}));
}

TEST(PixelSample, AlwaysHasIncludedPixels) {
    const Points list =
        points(R"("sites":60,"include":[[0,0],{"y":2,"height":1},{"x":15},{"x":3,"y":4,"width":2,"height":2}])");
    EXPECT_EQ(list.size(), 60U);
    const auto has = [&](int x, int y) { return std::ranges::find(list, std::array{x, y}) != list.end(); };
    EXPECT_TRUE(has(0, 0));
    for (int x = 0; x < 16; ++x) EXPECT_TRUE(has(x, 2)) << x;
    for (int y = 0; y < 12; ++y) EXPECT_TRUE(has(15, y)) << y;
    for (const auto& [x, y] : {std::pair{3, 4}, {4, 4}, {3, 5}, {4, 5}}) EXPECT_TRUE(has(x, y)) << x << ' ' << y;
}

TEST(PixelSample, CountsPixelsOfSeveralBlocksOnce) {
    // 16 + 12 - 1 pixels
    const std::string cross = R"("include":[{"y":2,"height":1},{"x":5,"width":1},[5,2],[5,2]])";
    EXPECT_EQ(points(R"("sites":27,)" + cross).size(), 27U);
    const auto fewer = answer(R"("sites":26,)" + cross);
    ASSERT_FALSE(fewer);
    EXPECT_EQ(fewer.error().code, ErrorCode::Unusable);
    EXPECT_EQ(fewer.error().field, "/include");
    EXPECT_EQ(fewer.error().message, "27 pixels are included, but there are only 26 sites");
}

TEST(PixelSample, HasTheFirstRowOfADensityAtTheTop) {
    for (const auto& [x, y] : points(R"("sites":96,"density":{"width":1,"height":2,"values":[0,1]})")) EXPECT_GE(y, 6);
    const std::vector<std::uint16_t> dark_at_top = {0, 255};
    const std::string picture = base64(*write_greys(dark_at_top, 1, 2, 8));
    for (const auto& [x, y] : points(R"("sites":96,"density":{"image":")" + picture + "\"}")) EXPECT_LT(y, 6);
}

TEST(PixelSample, RejectsADensityThatIsTooSmall) {
    const auto made = answer(R"("sites":97,"density":{"width":1,"height":2,"values":[0,1]})");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::Unusable);
    EXPECT_EQ(made.error().field, "/sites");
    EXPECT_EQ(made.error().message, "only 96 pixels have a density above 0 or are included, but there are 97 sites");
}

TEST(PixelSample, ReportsFieldsOfErrors) {
    EXPECT_EQ(fields(parse(R"("seed":1)")), "/sites");
    EXPECT_EQ(fields(parse(R"("sites":0)")), "/sites");
    EXPECT_EQ(fields(parse(R"("sites":193)")), "/sites");
    EXPECT_EQ(fields(parse(R"("sites":5,"mesh":true)")), "/mesh");
    EXPECT_EQ(fields(parse(R"("sites":5,"format":"svg","seed":-1)")), "/format,/seed");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":3)")), "/include");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":[[1,2],[3]])")), "/include/1");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":[[1,2],[3,-1]])")), "/include/1/1");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":[{"x":1,"z":2}])")), "/include/0/z");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":[[15,11],[16,0]])")), "/include/1");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":[{"x":10,"width":7}])")), "/include/0");
    EXPECT_EQ(fields(parse(R"("sites":5,"include":[{"y":12}])")), "/include/0");
    EXPECT_EQ(fields(parse(R"("sites":5,"calibration":{})")), "/calibration");
    EXPECT_EQ(fields(parse(R"("sites":5,"calibration":{"width":17})")), "/calibration");
    EXPECT_EQ(fields(parse(R"("sites":5,"calibration":{"x":1,"width":2})")), "/calibration/x");
    EXPECT_EQ(fields(parse(R"("sites":5)", R"("domain":{"type":"pixels","width":3})")), "/domain");
    EXPECT_EQ(fields(parse(R"("sites":5)", R"("domain":{"type":"pixels","width":3,"height":0})")), "/domain/height");
    EXPECT_EQ(fields(parse(R"("sites":5)", R"("domain":{"type":"pixels","width":3.5,"height":1})")), "/domain/width");
}

TEST(PixelSample, RejectsMorePixelsThanAllowed) {
    const auto request = parse(R"("sites":5)", kRaster, {.max_pixels = 191});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(request.error().field, "/domain");
    EXPECT_EQ(request.error().message, "domain has 16 x 12 pixels; this server's limit (max-pixels) is 191");
    EXPECT_TRUE(parse(R"("sites":5)", kRaster, {.max_sites = 4, .max_pixels = 192}));
}

TEST(PixelSample, AcceptsNoOptionsAsText) {
    const auto document = JsonDocument::parse(std::string("{\"sites\":5,") + kRaster + '}');
    const auto request = parse_pixels(document->root(), {{"seed", "1"}}, "", {});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().field, "seed");
}

TEST(PixelSample, IsRecognisedByItsDomain) {
    for (const char* other : {"[]", "{}", R"({"domain":"pixels"})", R"({"domain":{}})", R"({"domain":{"type":1}})",
                              R"({"domain":{"type":"torus","width":1,"height":1}})"})
        EXPECT_FALSE(asks_for_pixels(JsonDocument::parse(other)->root())) << other;
}

TEST(PixelSample, DependsOnTheSeed) {
    EXPECT_EQ(points(R"("sites":40)"), points(R"("sites":40,"seed":0)"));
    EXPECT_NE(points(R"("sites":40)"), points(R"("sites":40,"seed":1)"));
}

TEST(PixelSample, EndsAtAStop) {
    std::stop_source source;
    source.request_stop();
    const auto made = answer(R"("sites":40)", {source.get_token(), {}});
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::Stopped);
}

TEST(PixelSample, EstimatesMoreForMorePixels) {
    const auto cost = [](const std::string& side, const std::string& members) {
        return cost_of(*parse(members, R"("domain":{"type":"pixels","width":)" + side + R"(,"height":1000})"), {});
    };
    const Cost small = cost("100", R"("sites":100)"), large = cost("1000", R"("sites":100)");
    EXPECT_LT(small.memory, large.memory);
    EXPECT_LT(small.seconds, large.seconds);
    EXPECT_LT(large.memory, cost("1000", R"("sites":1000000)").memory);
}

}  // namespace
}  // namespace ccdt::api
