// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/heif_properties.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "tests/api/files.h"

namespace ccdt::api {
namespace {

using namespace std::string_literals;

/// Encodes a number in `size` bytes, big-endian.
std::string number(std::uint64_t value, std::size_t size) {
    std::string bytes(size, '\0');
    for (std::size_t i = size; i-- > 0; value >>= 8) bytes[i] = static_cast<char>(value & 0xFF);
    return bytes;
}

std::string box(const std::string& name, const std::string& data) {
    return number(8 + data.size(), 4) + name + data;
}

/// Builds a file whose primary item is the second one.
std::string file_of(const std::string& associations, const std::string& properties) {
    const std::string inside = number(0, 4) + box("pitm", number(0, 4) + number(2, 2)) +
                               box("iprp", box("ipco", properties) + box("ipma", associations));
    return box("ftyp", "avif"s + number(0, 4)) + box("meta", inside);
}

std::string names_of(std::string_view file) {
    std::string names;
    for (const Chunk& property : heif_properties(file)) names += std::string(property.name) + ' ';
    return names;
}

TEST(HeifProperties, BelongToThePrimaryItem) {
    EXPECT_EQ(names_of(fixture("lossless.avif")), "ispe pixi av1C colr ");
    EXPECT_EQ(names_of(fixture("rgba.avif")).find("auxC"), std::string::npos);
    const std::string properties = box("aaaa", "1") + box("bbbb", "2") + box("cccc", "3");
    const std::string first = number(1, 2) + "\1\1"s,
                      second = number(2, 2) + "\3\3\x82\0"s;  // number 0 means no property
    EXPECT_EQ(names_of(file_of(number(0, 4) + number(2, 4) + first + second, properties)), "cccc bbbb ");
    EXPECT_EQ(names_of(file_of(number(0, 4) + number(1, 4) + first, properties)), "");
}

TEST(HeifProperties, AcceptWideNumbers) {
    const std::string associations = number(0x0100'0001, 4) + number(1, 4) + number(2, 4) + "\1"s + number(0x8002, 2);
    EXPECT_EQ(names_of(file_of(associations, box("aaaa", "1") + box("bbbb", "2"))), "bbbb ");
}

TEST(HeifProperties, AreMissingIfTheFileIsInconsistent) {
    const std::string most = number(0xFFFF'FFFF, 4);
    EXPECT_EQ(names_of(file_of(number(0, 4) + most + number(2, 2) + "\xff\1"s, box("aaaa", "1"))), "aaaa ");
    EXPECT_EQ(names_of(file_of(number(0, 4) + most, box("aaaa", "1"))), "");
    EXPECT_EQ(names_of(""), "");
    EXPECT_EQ(names_of(box("meta", "")), "");
    EXPECT_EQ(names_of(number(7, 4) + "meta"), "") << "the box is smaller than its header";
}

TEST(HeifProperties, StayWithinDamagedFiles) {
    std::mt19937 random(3);
    for (const auto* name : {"rgba.avif", "tiles.avif", "film.avif", "tiles.heic", "film.heic"}) {
        const std::string file = fixture(name).substr(0, 700);
        for (int round = 0; round < 5000; ++round) {
            std::string damaged = file.substr(0, 1 + random() % file.size());
            for (unsigned i = 0; i < random() % 4; ++i)
                damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
            for (const std::string_view type : heif_item_types(damaged)) ASSERT_EQ(type.size(), 4U);
            for (const Chunk& property : heif_properties(damaged)) {
                ASSERT_GE(property.data.data(), damaged.data());
                ASSERT_LE(property.data.data() + property.data.size(), damaged.data() + damaged.size());
            }
        }
    }
}

/// Returns a file with a picture of 100 x 60 pixels and a crop.
std::string cropped(int width, int height, int x, int y, int denominator = 1) {
    std::string clap;
    for (const int value : {width, height, x, y})
        clap += number(static_cast<std::uint32_t>(value), 4) + number(static_cast<std::uint32_t>(denominator), 4);
    const std::string properties = box("ispe", number(0, 4) + number(100, 4) + number(60, 4)) + box("clap", clap);
    return file_of(number(0, 4) + number(1, 4) + number(2, 2) + "\2\1\2"s, properties);
}

TEST(HeifView, IsTheCropRoundedDown) {
    const auto view_of = [](const std::string& file) { return heif_view(heif_properties(file)); };
    const auto odd = view_of(cropped(42, 30, 59, -30, 2));
    ASSERT_TRUE(odd);
    EXPECT_EQ(odd->whole_width, 100U);
    EXPECT_EQ(std::vector({odd->width, odd->height}), (std::vector<std::uint32_t>{21, 15}));
    EXPECT_EQ(std::vector({odd->left, odd->top}), (std::vector<std::uint32_t>{69, 7}));
    EXPECT_TRUE(view_of(cropped(100, 60, 0, 0)));
    EXPECT_TRUE(view_of(cropped(50, 60, 25, 0)));
    for (const auto& file : {cropped(50, 60, 26, 0), cropped(50, 60, -26, 0), cropped(101, 60, 0, 0),
                             cropped(0, 60, 0, 0), cropped(50, 30, 0, -16), cropped(50, 60, 0, 0, 0)})
        EXPECT_FALSE(view_of(file));
}

TEST(HeifView, IsTurnedInTheOrderOfTheProperties) {
    const std::string size = box("ispe", number(0, 4) + number(100, 4) + number(60, 4)),
                      crop = box("clap", number(50, 4) + number(1, 4) + number(50, 4) + number(1, 4) + number(0, 4) +
                                             number(1, 4) + number(0, 4) + number(1, 4));
    const auto view_of = [&](const std::string& first, const std::string& second) {
        const std::string associations = number(0, 4) + number(1, 4) + number(2, 2) + "\3\1\2\3"s;
        return heif_view(heif_properties(file_of(associations, size + first + second)));
    };
    const auto rotation = [](std::uint64_t quarters) { return box("irot", number(quarters, 1)); };
    const std::string flip = box("imir", number(0, 1)), mirror = box("imir", number(1, 1)), none = rotation(0);
    const std::string left = rotation(1), half = rotation(2), right = rotation(3);
    int orientation = 0;
    for (const auto& [first, second] :
         {std::pair{none, none}, std::pair{none, mirror}, std::pair{half, none}, std::pair{none, flip},
          std::pair{left, flip}, std::pair{none, right}, std::pair{left, mirror}, std::pair{left, none}})
        EXPECT_EQ(view_of(first, second)->orientation, ++orientation);
    EXPECT_EQ(view_of(mirror, left)->orientation, 5) << "the opposite of a rotation before the mirroring";
    EXPECT_EQ(view_of(mirror, flip)->orientation, 3);
    EXPECT_EQ(view_of(right, left)->orientation, 1);
    EXPECT_EQ(view_of(crop, left)->orientation, 8);
    EXPECT_FALSE(view_of(left, crop));
}

TEST(MisreadGrid, HasTilesInAnotherOrderOrWithAlpha) {
    // Item 5 is alpha.
    const std::string properties =
        box("iprp", box("ipco", box("auxC", number(0, 4) + "urn:mpeg:mpegB:cicp:systems:auxiliary:alpha\0"s)) +
                        box("ipma", number(0, 4) + number(1, 4) + number(5, 2) + "\1\1"s));
    const auto file_with = [&](const std::string& references) {
        return box("meta", number(0, 4) + box("pitm", number(0, 4) + number(1, 2)) + properties +
                               box("iref", number(0, 4) + references));
    };
    const auto reference = [](const std::string& type, std::uint32_t from, const std::vector<std::uint32_t>& to) {
        std::string data = number(from, 2) + number(to.size(), 2);
        for (const std::uint32_t item : to) data += number(item, 2);
        return box(type, data);
    };
    EXPECT_EQ(misread_grid(file_with(reference("dimg", 1, {2, 3}) + reference("auxl", 4, {1}))), "");
    EXPECT_NE(misread_grid(file_with(reference("dimg", 1, {3, 2}))), "");
    EXPECT_NE(misread_grid(file_with(reference("dimg", 1, {2, 3}) + reference("auxl", 5, {3}))), "");
    EXPECT_EQ(misread_grid(file_with(reference("dimg", 1, {2, 3}) + reference("auxl", 6, {3}))), "") << "depth";
    EXPECT_EQ(misread_grid(file_with(reference("dimg", 9, {3, 2}) + reference("auxl", 5, {3}))), "");
    EXPECT_EQ(misread_grid(fixture("tiles.avif")), "");
    EXPECT_EQ(misread_grid(fixture("rgba.avif")), "");
}

TEST(HeifItemTypes, AreThoseOfAllItems) {
    using Types = std::vector<std::string_view>;
    const std::string tiles = fixture("tiles.heic"), grey = fixture("grey.avif");
    EXPECT_EQ(heif_item_types(tiles), (Types{"grid", "hvc1", "hvc1"}));
    EXPECT_EQ(heif_item_types(grey), Types{"av01"});
    EXPECT_EQ(heif_item_types(fixture("track.heic")), Types{});
    const std::string wide = number(0x0300'0000, 4) + number(1, 4) + number(0, 2) + "jpeg"s,
                      odd = "\2\0\0\0\0\1\0\0\xff\n\0."s;
    const std::string list = box("iinf", number(0x0100'0000, 4) + number(2, 4) + box("infe", wide) + box("infe", odd));
    const std::string file = box("ftyp", "mif1"s + number(0, 4)) + box("meta", number(0, 4) + list);
    EXPECT_EQ(heif_item_types(file), Types{"jpeg"});
}

TEST(HeifBrand, IsFoundInAnyPosition) {
    EXPECT_TRUE(is_avif(box("ftyp", "avif"s + number(0, 4))));
    EXPECT_TRUE(is_avif(box("ftyp", "avis"s + number(0, 4))));
    EXPECT_TRUE(is_avif(box("ftyp", "mif1"s + number(0, 4) + "miafavif")));
    EXPECT_FALSE(is_avif(box("ftyp", "mif1avif"))) << "the name is at the position of the version";
    EXPECT_FALSE(is_avif(box("ftyp", "heic"s + number(0, 4) + "mif1heic")));
    EXPECT_FALSE(is_avif(box("ftyp", "heic"s + number(0, 4)) + "avif")) << "the name is outside the box";
    EXPECT_FALSE(is_avif(fixture("grey.gif")));
    EXPECT_TRUE(is_heic(fixture("lossless.heic")));
    EXPECT_TRUE(is_heic(box("ftyp", "mif1"s + number(0, 4))));
    EXPECT_FALSE(is_heic(fixture("lossless.avif")));
    EXPECT_FALSE(is_heic(box("ftyp", "isom"s + number(0, 4) + "mp42")));
}

TEST(MediaBox, ReadsAllThreeKindsOfSize) {
    const std::string file =
        number(1, 4) + "long" + number(20, 8) + "abcd" + box("next", "ef") + number(0, 4) + "last12";
    const auto wide = media_box(file, 0);
    ASSERT_TRUE(wide);
    EXPECT_EQ(wide->name, "long");
    EXPECT_EQ(wide->data, "abcd");
    const auto next = media_box(file, wide->end);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->data, "ef");
    const auto last = media_box(file, next->end);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->name, "last");
    EXPECT_EQ(last->data, "12");
    EXPECT_FALSE(media_box(file, last->end));
    const std::string wraps = number(1, 4) + "wrap" + number(~std::uint64_t{0}, 8) + "abcd";
    EXPECT_EQ(media_box(wraps, 0)->end, wraps.size());
    EXPECT_FALSE(media_box(number(1, 4) + "wrap" + number(15, 8), 0));
}

}  // namespace
}  // namespace ccdt::api
