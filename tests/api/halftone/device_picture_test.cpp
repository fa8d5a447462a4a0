// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/device_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/api/files.h"

namespace ccdt::api {
namespace {

using Options = std::vector<TextOption>;

Result<DeviceRequest> parse(const Options& options, const Limits& limits = {}) {
    static const std::string file = photograph("astronaut.png");
    return parse_device(read_halftone(file, options, limits), "", limits);
}

Result<Answer> answer(const Options& options) {
    const auto request = parse(options);
    if (!request) return tl::unexpected(request.error());
    Timings timings;
    return run_device(*request, {}, decode_inline(), {}, timings);
}

TEST(DevicePicture, HasTheRequestedSize) {
    const auto png = decode_png(answer({{"device", "bwr"}, {"width", "70"}, {"height", "30"}})->body);
    EXPECT_EQ(png.width, 70);
    EXPECT_EQ(png.height, 30);
    EXPECT_EQ(png.bit_depth, 2);
}

TEST(DevicePicture, HasOnlyColoursOfTheDevice) {
    const auto request = parse({{"device", "acep7"}, {"width", "60"}});
    const auto png = decode_png(answer({{"device", "acep7"}, {"width", "60"}})->body);
    for (const auto& [red, green, blue, alpha] : png.pixels) {
        const Colour colour{red, green, blue};
        EXPECT_NE(std::ranges::find(request->device.sent, colour), request->device.sent.end());
        EXPECT_EQ(alpha, 255);
    }
}

TEST(DevicePicture, FollowsTheAspectRatioIfOneSideIsGiven) {
    EXPECT_EQ(decode_png(answer({{"device", "1bit"}, {"height", "40"}})->body).width, 40);
    EXPECT_EQ(decode_png(answer({{"device", "1bit"}})->body).height, 512);
}

TEST(DevicePicture, RejectsOptionsOfDots) {
    for (const char* option : {"sites", "scale", "dots", "color", "style", "antialias"}) {
        const auto request = parse({{"device", "1bit"}, {option, "1"}});
        ASSERT_FALSE(request) << option;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, option);
    }
}

TEST(DevicePicture, RejectsSpotsOfDevicesWithMoreColours) {
    EXPECT_EQ(parse({{"device", "1bit"}, {"spot", "1.5"}})->spot, 1.5);
    EXPECT_EQ(parse({{"device", "custom"}, {"palette", "#fff,#024"}, {"spot", "2"}})->spot, 2);
    for (const Options& options :
         {Options{{"device", "gray4"}, {"spot", "1.5"}}, Options{{"device", "1bit"}, {"spot", "0.9"}}}) {
        const auto request = parse(options);
        ASSERT_FALSE(request);
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, "spot");
    }
}

TEST(DevicePicture, RejectsMorePixelsThanAllowed) {
    const auto request = parse({{"device", "1bit"}, {"width", "2000"}}, {.max_pixels = 300'000});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(request.error().field, "width");
}

TEST(DevicePicture, NeedsASizeForLargePictures) {
    ImageFile large;
    large.header.width = 4001;
    large.header.height = 1000;
    const auto parsed = [&](const Options& options) {
        return parse_device(read_halftone(Result<ImageFile>(large), options), "", {});
    };
    const auto request = parsed({{"device", "1bit"}});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(request.error().field, "width");
    EXPECT_NE(request.error().message.find("4001 x 1000"), std::string::npos);
    EXPECT_TRUE(parsed({{"device", "1bit"}, {"width", "4001"}}));
    EXPECT_TRUE(parsed({{"device", "1bit"}, {"height", "1000"}}));
    large.header.width = 4000;
    EXPECT_TRUE(parsed({{"device", "1bit"}}));
}

TEST(DevicePicture, ReportsAllErrorsOfARequest) {
    const auto request = parse({{"device", "tv"}, {"rotate", "45"}});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().field, "device");
    ASSERT_EQ(request.error().others.size(), 1U);
    EXPECT_EQ(request.error().others.front().field, "rotate");
}

TEST(DevicePicture, EstimatesMoreForMorePixelsColoursAndSpots) {
    const auto cost = [](const Options& options) { return cost_of(*parse(options), {}); };
    const Cost small = cost({{"device", "1bit"}, {"width", "200"}});
    const Cost large = cost({{"device", "1bit"}, {"width", "2000"}});
    const Cost colourful = cost({{"device", "acep7"}, {"width", "2000"}});
    EXPECT_LT(small.memory, large.memory);
    EXPECT_LT(small.seconds, large.seconds);
    EXPECT_LT(large.seconds, colourful.seconds);
    EXPECT_LT(large.seconds, cost({{"device", "1bit"}, {"width", "2000"}, {"spot", "1.5"}}).seconds);
}

}  // namespace
}  // namespace ccdt::api
