// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/mask/threshold_mask.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "api/sample/plane/sample_cost.h"
#include "api/sample/plane/sample_parser.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

Result<SampleRequest> parse(const std::string& members, const std::string& format = "mask") {
    return parse_sample("{\"format\":\"" + format + "\"," + members + '}', {}, "", {});
}

std::string torus(const std::string& width, const std::string& height) {
    return R"("domain":{"type":"torus","width":)" + width + R"(,"height":)" + height + '}';
}

Result<Answer> answer(const SampleRequest& request, const Control& control = {}) {
    Timings timings;
    return run_mask(*request.threshold_mask, control, timings);
}

TEST(Mask, IsAGreyPng) {
    for (const std::string format : {"mask", "mask16"}) {
        const auto request = parse(torus("32", "24"), format);
        ASSERT_TRUE(request) << request.error().message;
        const auto made = answer(*request);
        ASSERT_TRUE(made) << made.error().message;
        EXPECT_EQ(made->media_type, "image/png");
        EXPECT_EQ(made->body.substr(16, 8), std::string("\0\0\0\x20\0\0\0\x18", 8));
        EXPECT_EQ(made->body[24], format == "mask" ? 8 : 16);  // the bit depth; the next byte is the colour type, grey
        EXPECT_EQ(made->body[25], 0);
        EXPECT_EQ(answer(*request)->body, made->body);
    }
}

std::string animated(const std::string& depth, const std::string& side = "16") {
    return R"("domain":{"type":"torus","width":)" + side + R"(,"height":)" + side + R"(,"depth":)" + depth + '}';
}

TEST(Mask, StacksFramesInAPng) {
    const auto made = answer(*parse(animated("3"), "mask"));
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->body.substr(16, 8), std::string("\0\0\0\x10\0\0\0\x30", 8));
}

TEST(Mask, WritesFramesAsAnArray) {
    const auto made = answer(*parse(animated("3"), "masknpy"));
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->media_type, "application/x-npy");
    EXPECT_NE(made->body.find("'<u2', 'fortran_order': False, 'shape': (3, 16, 16), }"), std::string::npos);
    EXPECT_EQ(made->body.size() % 64, 3 * 16 * 16 * 2 % 64);
    EXPECT_NE(answer(*parse(torus("16", "8"), "masknpy"))->body.find("(8, 16), }"), std::string::npos);
}

TEST(Mask, LimitsItsFrames) {
    for (const auto& [depth, side] : {std::pair{"0", "16"}, {"257", "16"}, {"1.5", "16"}, {"5", "1024"}})
        EXPECT_EQ(parse(animated(depth, side)).error().field, "/domain/depth") << depth;
    EXPECT_TRUE(parse(animated("256")));
    EXPECT_EQ(parse(R"("domain":{"type":"box","width":16,"height":16,"depth":2})").error().field, "/format");
}

TEST(Mask, RequiresATorusWithIntegerSides) {
    for (const std::string side : {"7", "1025", "64.5", "1e300"}) {
        EXPECT_EQ(parse(torus(side, "64")).error().field, "/domain/width") << side;
        EXPECT_EQ(parse(torus("64", side)).error().field, "/domain/height") << side;
    }
    EXPECT_FALSE(parse(R"("polygon":[[0,0],[64,0],[64,64]])"));
    EXPECT_FALSE(parse(R"("domain":{"type":"rectangle","width":64,"height":64})"));
}

TEST(Mask, RefusesOptionsOfPoints) {
    for (const auto& [name, value] : {std::pair<std::string, std::string>{"sites", "10"},
                                      {"fixed", "[[1,1]]"},
                                      {"order", R"("progressive")"},
                                      {"density", R"({"width":1,"height":1,"values":[1]})"},
                                      {"quality", R"("best")"},
                                      {"passes", "5"},
                                      {"method", R"("lloyd")"},
                                      {"mesh", "false"},
                                      {"dot", "1"},
                                      {"coordinates", R"("plane")"}}) {
        const auto request = parse(torus("64", "64") + ",\"" + name + "\":" + value);
        ASSERT_FALSE(request) << name;
        EXPECT_EQ(request.error().code, ErrorCode::Malformed);
        EXPECT_EQ(request.error().field, "/" + name);
    }
    EXPECT_TRUE(parse(torus("64", "64") + R"(,"seed":7)"));
}

TEST(Mask, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const auto stopped = answer(*parse(torus("64", "64")), {source.get_token(), {}});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, ErrorCode::Stopped);
}

TEST(Mask, CostsMoreForLargerSides) {
    const Cost small = cost_of(*parse(torus("64", "64")), {}), large = cost_of(*parse(torus("1024", "1024")), {});
    EXPECT_GT(large.seconds, 100 * small.seconds);
    EXPECT_GT(large.memory, small.memory);
}

}  // namespace
}  // namespace ccdt::api
