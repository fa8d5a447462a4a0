// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/drawing_size.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ccdt::api {
namespace {

struct Asked {
    std::optional<int> width;
    std::optional<int> height;
    Fit fit = Fit::Contain;
};

HalftoneRequest request_of(const Asked& asked) {
    HalftoneRequest request;
    request.width = asked.width;
    request.height = asked.height;
    request.fit = asked.fit;
    request.on_screen = true;
    return request;
}

/// Returns width and height of the canvas of a picture.
std::pair<int, int> size_of(const Asked& asked, PictureSize picture, const Limits& limits = {}) {
    const HalftoneRequest request = request_of(asked);
    const Canvas canvas = *settled_canvas(request, drawn_part(request, picture), limits);
    return {canvas.width, canvas.height};
}

std::pair<int, int> part_of(const Asked& asked, PictureSize picture) {
    const PictureSize part = drawn_part(request_of(asked), picture);
    return {part.width, part.height};
}

using Size = std::pair<int, int>;

TEST(DrawingSize, KeepsTheAspectRatioForOneSide) {
    EXPECT_EQ(size_of({640, {}}, {451, 300}), Size(640, 426));
    EXPECT_EQ(size_of({{}, 100}, {451, 300}), Size(150, 100));
    EXPECT_EQ(size_of({1, {}}, {300, 451}), Size(1, 2));
    EXPECT_EQ(size_of({10, {}}, {1000, 1}), Size(10, 1)) << "at least a pixel";
    EXPECT_EQ(size_of({65'535, {}}, {1, 100'000}).first, 65'535);
}

TEST(DrawingSize, ContainsThePictureWithinBothSides) {
    EXPECT_EQ(size_of({640, 640}, {451, 300}), Size(640, 426));
    EXPECT_EQ(size_of({640, 100}, {451, 300}), Size(150, 100));
    EXPECT_EQ(size_of({451, 300}, {451, 300}), Size(451, 300));
    EXPECT_EQ(part_of({640, 100}, {451, 300}), Size(451, 300));
}

TEST(DrawingSize, NeverExceedsTheGivenSides) {
    for (int width = 1; width < 40; ++width) {
        for (int height = 1; height < 40; ++height) {
            const Size size = size_of({17, 13}, {width, height});
            EXPECT_LE(size.first, 17) << width << 'x' << height;
            EXPECT_LE(size.second, 13) << width << 'x' << height;
            EXPECT_TRUE(size.first == 17 || size.second == 13) << width << 'x' << height;
        }
    }
}

TEST(DrawingSize, CropsToTheMiddleToCoverBothSides) {
    EXPECT_EQ(size_of({200, 200, Fit::Cover}, {451, 300}), Size(200, 200));
    EXPECT_EQ(part_of({200, 200, Fit::Cover}, {451, 300}), Size(300, 300));
    EXPECT_EQ(part_of({100, 37, Fit::Cover}, {451, 300}), Size(451, 167));
    EXPECT_EQ(size_of({1000, 990, Fit::Cover}, {24, 16}), Size(1000, 990));
    EXPECT_EQ(part_of({1, 65'535, Fit::Cover}, {24, 16}), Size(1, 16)) << "at least a pixel";
}

TEST(DrawingSize, HasTheScaleThatPreservesAreas) {
    const Canvas canvas = *settled_canvas(request_of({640, {}}), {451, 300}, {});
    EXPECT_NEAR(canvas.scale * canvas.scale, 640.0 * 426 / (451 * 300), 1e-12);
}

TEST(DrawingSize, FitsAScreen) {
    EXPECT_EQ(size_of({}, {512, 384}), Size(1067, 800));
    EXPECT_EQ(size_of({}, {6000, 4000}), Size(1200, 800));
    EXPECT_EQ(size_of({}, {1920, 1080}), Size(1280, 720));
    EXPECT_EQ(size_of({}, {512, 512}), Size(1000, 1000));
    EXPECT_EQ(size_of({}, {3000, 4000}), Size(750, 1000));
    EXPECT_EQ(size_of({}, {1, 1}), Size(1000, 1000));
    EXPECT_EQ(size_of({}, {1, 60'000}), Size(1, 1000));
}

TEST(DrawingSize, ReducesAScreenDrawingToThePixelLimit) {
    const Size size = size_of({}, {400, 200}, {.max_pixels = 80'000});
    EXPECT_EQ(size, Size(400, 200));
}

TEST(DrawingSize, DependsOnTheDotsInPrint) {
    HalftoneRequest request;
    EXPECT_FALSE(settled_canvas(request, {451, 300}, {}));
    request.scale = 2;
    EXPECT_EQ(settled_canvas(request, {451, 300}, {})->width, 902);
}

}  // namespace
}  // namespace ccdt::api
