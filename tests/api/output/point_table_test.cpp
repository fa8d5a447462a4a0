// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/point_table.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/api/output/whole_body.h"

namespace ccdt::api {
namespace {

const std::vector<Point> kPoints = {{0.1, 1e300}, {-0.0, 5e-324}, {1.0 / 3, 2}};

Distribution dots_at(std::vector<Point> points) {
    Distribution dots;
    dots.points = std::move(points);
    return dots;
}

/// Writes the points of one ink without a name.
std::string write_points(const std::function<void(std::span<const InkDots>, Body&)>& write, std::vector<Point> points) {
    const Ink ink;
    const Distribution dots = dots_at(std::move(points));
    const InkDots inks{ink, dots};
    return test::whole_body([&](Body& body) { write({&inks, 1}, body); });
}

std::string csv_of(std::vector<Point> points, const std::stop_token& stop = {}) {
    return write_points([&](std::span<const InkDots> inks, Body& body) { write_csv({inks}, body, stop); },
                        std::move(points));
}

std::string npy_of(std::vector<Point> points) {
    return write_points([](std::span<const InkDots> inks, Body& body) { write_npy({inks}, body); }, std::move(points));
}

const Ink kCyan{"cyan", {0, 255, 255}}, kMagenta{"magenta", {255, 0, 255}}, kOther{"#abcdef", {0xab, 0xcd, 0xef}};

std::stop_token stopped_token() {
    std::stop_source source;
    source.request_stop();
    return source.get_token();
}

TEST(Csv, HasHeaderAndShortestNumbers) {
    EXPECT_EQ(csv_of(kPoints), "x,y\r\n0.1,1e+300\r\n-0,5e-324\r\n0.3333333333333333,2\r\n");
    EXPECT_EQ(csv_of({}), "x,y\r\n");
}

TEST(Csv, StopsOnRequest) {
    EXPECT_EQ(csv_of(kPoints, stopped_token()), "x,y\r\n");
}

TEST(Csv, NamesInks) {
    const Distribution some = dots_at(kPoints), none, one = dots_at({{1, 2}});
    const std::vector<InkDots> inks = {{kCyan, some}, {kMagenta, none}, {kOther, one}};
    EXPECT_EQ(test::whole_body([&](Body& body) { write_csv({inks}, body); }),
              "x,y,ink\r\n0.1,1e+300,cyan\r\n-0,5e-324,cyan\r\n0.3333333333333333,2,cyan\r\n1,2,#abcdef\r\n");
}

TEST(Npy, HasValidHeader) {
    for (const std::size_t count : {0U, 1U, 9U, 10U, 12'345U}) {
        const std::string file = npy_of(std::vector<Point>(count));
        ASSERT_TRUE(file.starts_with(std::string("\x93NUMPY\x01\x00", 8)));
        const auto length = static_cast<std::size_t>(static_cast<unsigned char>(file[8])) +
                            256 * static_cast<std::size_t>(static_cast<unsigned char>(file[9]));
        EXPECT_EQ((10 + length) % 64, 0U);
        EXPECT_EQ(file[10 + length - 1], '\n');
        EXPECT_EQ(file.size(), 10 + length + count * 16);
        EXPECT_NE(file.find("'shape': (" + std::to_string(count) + ", 2)"), std::string::npos);
    }
}

TEST(Npy, NumbersInks) {
    const Distribution none, one = dots_at({{1, 2}});
    const std::vector<InkDots> inks = {{kCyan, one}, {kMagenta, none}, {kOther, one}};
    const std::string file = test::whole_body([&](Body& body) { write_npy({inks}, body); });
    EXPECT_NE(file.find("'shape': (2, 3)"), std::string::npos);
    const double rows[] = {1, 2, 0, 1, 2, 2};
    ASSERT_EQ(file.size() % 64, sizeof(rows));
    EXPECT_EQ(std::memcmp(file.data() + file.size() - sizeof(rows), rows, sizeof(rows)), 0);
}

TEST(Npy, StoresNumbersInBinary) {
    const std::string file = npy_of(kPoints);
    ASSERT_GE(file.size(), 48U);
    EXPECT_EQ(std::memcmp(file.data() + file.size() - 48, kPoints.data(), 48), 0);
}

}  // namespace
}  // namespace ccdt::api
