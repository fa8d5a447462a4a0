// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/surface_sample.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <variant>
#include <vector>

namespace ccdt::api {
namespace {

const SurfaceFile kFile{"bytes", {}};

Result<SurfaceRequest> parse(std::vector<TextOption> options, std::string_view accept = "", const Limits& limits = {}) {
    options.insert(options.begin(), {"sites", "10"});
    return parse_surface(kFile, options, accept, limits);
}

Error error_of(const std::vector<TextOption>& options, std::string_view accept = "") {
    const auto request = parse(options, accept);
    return request ? Error{} : request.error();
}

TEST(SurfaceRequest, HasDocumentedDefaults) {
    const auto request = parse({});
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->file.bytes, "bytes");
    EXPECT_EQ(request->run.sites, 10U);
    EXPECT_EQ(request->run.seed, 0U);
    EXPECT_EQ(request->run.iterations, 5);
    EXPECT_EQ(request->run.passes, 5);
    EXPECT_EQ(request->run.quality, Quality::Standard);
    EXPECT_FALSE(request->run.keep_mesh);
    EXPECT_TRUE(request->run.fixed.empty());
    EXPECT_EQ(std::get<SurfaceDensityKind>(request->density), SurfaceDensityKind::Uniform);
    EXPECT_FALSE(request->crease);
    EXPECT_EQ(request->order, PointOrder::None);
    EXPECT_EQ(request->on_deadline, OnStop::Error);
    EXPECT_EQ(request->format->file.name, "json");
}

TEST(SurfaceRequest, ReadsEveryOption) {
    const auto request = parse({{"seed", "3"},
                                {"iterations", "7"},
                                {"passes", "2"},
                                {"quality", "best"},
                                {"on_deadline", "partial"},
                                {"density", "[0, 1.5,2]"},
                                {"crease", "90"},
                                {"fixed", "[[1,2,3],[-4,5e-1,6]]"},
                                {"order", "progressive"},
                                {"mesh", "true"},
                                {"format", "glb"}});
    ASSERT_TRUE(request) << request.error().message;
    EXPECT_EQ(request->run.seed, 3U);
    EXPECT_EQ(request->run.iterations, 7);
    EXPECT_EQ(request->run.passes, 2);
    EXPECT_EQ(request->run.quality, Quality::Best);
    EXPECT_EQ(request->on_deadline, OnStop::Partial);
    EXPECT_EQ(std::get<std::vector<double>>(request->density), (std::vector<double>{0, 1.5, 2}));
    EXPECT_DOUBLE_EQ(request->crease.value_or(0), std::numbers::pi / 2);
    EXPECT_EQ(request->run.fixed, (std::vector<Point3>{{1, 2, 3}, {-4, 0.5, 6}}));
    EXPECT_EQ(request->order, PointOrder::Progressive);
    EXPECT_TRUE(request->run.keep_mesh);
    EXPECT_EQ(request->format->file.name, "glb");
}

TEST(SurfaceRequest, ReadsDensitiesOfTheMesh) {
    EXPECT_EQ(std::get<SurfaceDensityKind>(parse({{"density", "color"}})->density), SurfaceDensityKind::Colour);
    EXPECT_EQ(std::get<SurfaceDensityKind>(parse({{"density", "curvature"}})->density), SurfaceDensityKind::Curvature);
}

TEST(SurfaceRequest, NamesInvalidOptions) {
    struct Case {
        TextOption option;
        std::string field;
    };
    const std::vector<Case> cases = {
        {{"seed", "-1"}, "seed"},
        {{"iterations", "1001"}, "iterations"},
        {{"passes", "0"}, "passes"},
        {{"quality", "stealthy"}, "quality"},
        {{"on_deadline", "x"}, "on_deadline"},
        {{"density", "colour"}, "density"},
        {{"density", "[1,"}, "density"},
        {{"density", "[1,-1]"}, "density/1"},
        {{"density", "[null]"}, "density/0"},
        {{"crease", "0"}, "crease"},
        {{"crease", "181"}, "crease"},
        {{"fixed", "{}"}, "fixed"},
        {{"fixed", "[[1,2]]"}, "fixed/0"},
        {{"fixed", "[[1,2,3],[1,2,\"3\"]]"}, "fixed/1"},
        {{"fixed", "[7]"}, "fixed/0"},
        {{"order", "path"}, "order"},
        {{"order", "up"}, "order"},
        {{"mesh", "yes"}, "mesh"},
        {{"format", "svg"}, "format"},
        {{"width", "7"}, "width"},
        {{"sites", "7"}, "sites"},
    };
    for (const auto& [option, field] : cases) {
        const Error error = error_of({option});
        EXPECT_EQ(error.code, ErrorCode::Malformed) << option.name << '=' << option.value;
        EXPECT_EQ(error.field, field) << option.name << '=' << option.value;
        EXPECT_NE(error.message.find(option.name), std::string::npos) << error.message;
    }
}

TEST(SurfaceRequest, RefusesDensitiesThatAreZeroEverywhere) {
    EXPECT_EQ(error_of({{"density", "[0,0]"}}).code, ErrorCode::Unusable);
    EXPECT_EQ(error_of({{"density", "[]"}}).field, "density");
}

TEST(SurfaceRequest, ExplainsWhyPathsAreRefused) {
    EXPECT_NE(error_of({{"order", "path"}}).message.find("in the plane"), std::string::npos);
}

TEST(SurfaceRequest, RequiresSites) {
    const auto request = parse_surface(kFile, {}, "", {});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().message, "sites is missing");
    EXPECT_EQ(request.error().field, "sites");
}

TEST(SurfaceRequest, ReportsErrorsOfTheFileBesideThoseOfOptions) {
    const auto request =
        parse_surface(failure(ErrorCode::Unusable, "broken"), {{"sites", "1"}, {"crease", "x"}}, "", {});
    ASSERT_FALSE(request);
    EXPECT_EQ(request.error().field, "crease");
    ASSERT_EQ(request.error().others.size(), 1U);
    EXPECT_EQ(request.error().others.front().message, "broken");
}

TEST(SurfaceRequest, LimitsSitesAndFixedPoints) {
    const Limits limits{.max_sites = 10};
    EXPECT_TRUE(parse({}, "", limits));
    const auto many = parse({{"fixed", "[[1,2,3],[1,2,3]]"}}, "", {.max_sites = 1});
    ASSERT_FALSE(many);
    EXPECT_EQ(many.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(parse({}, "", {.max_sites = 9}).error().code, ErrorCode::LimitExceeded);
}

TEST(SurfaceRequest, NegotiatesTheFormat) {
    EXPECT_EQ(parse({}, "model/ply")->format->file.name, "ply");
    EXPECT_EQ(parse({}, "text/csv;q=0.5, model/gltf-binary")->format->file.name, "glb");
    EXPECT_EQ(parse({{"format", "npy"}}, "model/ply")->format->file.name, "npy");
    EXPECT_EQ(error_of({}, "image/png").code, ErrorCode::NotAcceptable);
}

TEST(SurfaceRequest, NeedsTheTriangulationForSomeFormats) {
    for (const std::string format : {"obj", "stl"}) {
        EXPECT_EQ(error_of({{"format", format}}).field, "mesh") << format;
        EXPECT_TRUE(parse({{"format", format}, {"mesh", "1"}})) << format;
    }
    EXPECT_EQ(error_of({}, "model/obj").field, "mesh");
    for (const std::string format : {"json", "csv", "npy", "ply", "glb"}) EXPECT_TRUE(parse({{"format", format}}));
}

}  // namespace
}  // namespace ccdt::api
