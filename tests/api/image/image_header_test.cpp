// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/image_header.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "api/image/containers.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kMaxPixels = 1'000'000;

TEST(ImageHeader, ReadsTheSizeOfEveryFormat) {
    for (const auto* name : {"grey.jpg",    "progressive.jpg", "cmyk.jpg",       "lossy.webp",     "lossless.webp",
                             "grey-16.png", "palette.png",     "lzw.tif",        "big-endian.tif", "tiled.tif",
                             "float.tif",   "grey.gif",        "interlaced.gif", "rgb.bmp",        "from-top.bmp",
                             "runs-8.bmp",  "fields.bmp",      "lossless.avif",  "grey.avif",      "film.avif"}) {
        const auto header = read_image_header(fixture(name), kMaxPixels);
        ASSERT_TRUE(header) << name << ": " << header.error().message;
        EXPECT_EQ(header->width, 24U) << name;
        EXPECT_EQ(header->height, 16U) << name;
    }
    const auto animated = read_image_header(fixture("orientation-6.webp"), kMaxPixels);  // in the extended format
    ASSERT_TRUE(animated);
    EXPECT_EQ(animated->pixels(), 24U * 16U);
}

TEST(ImageHeader, EstimatesTheMemoryOfTheDecoder) {
    const auto decoder_bytes = [](const char* name) {
        return read_image_header(fixture(name), kMaxPixels)->decoder_bytes;
    };
    const auto by_rows = decoder_bytes("grey-16.png");
    EXPECT_LT(by_rows, 32U << 20);
    EXPECT_GE(decoder_bytes("cmyk.jpg"), by_rows + 24U * 16U * 4U * 2U);
    EXPECT_GE(decoder_bytes("lossless.webp"), by_rows + 24U * 16U * 8U);
    EXPECT_GE(decoder_bytes("float.tif"), by_rows + 24U * 16U * 4U);
    EXPECT_LT(decoder_bytes("float.tif"), 32U << 20);
    EXPECT_GE(decoder_bytes("huge-tile.tif"), by_rows + kMaxTilePixels);
    EXPECT_GE(decoder_bytes("grey.gif"), by_rows + 24U * 16U);
    EXPECT_GE(decoder_bytes("runs-8.bmp"), by_rows + 24U * 16U);
    EXPECT_GE(decoder_bytes("lossless.avif"), by_rows + 24U * 16U * 15U);
    EXPECT_GE(decoder_bytes("ramp.avif"), by_rows + 256U * 256U * 30U) << "more than 8 bits need more memory";
    EXPECT_GE(decoder_bytes("lossless.heic"), by_rows + 24U * 16U * 16U);
    EXPECT_GE(decoder_bytes("ramp.heic"), by_rows + 256U * 256U * 32U) << "more than 8 bits need more memory";
    EXPECT_GE(decoder_bytes("p3.jpg"), by_rows + fixture("p3.jpg").size() + (32U << 20));
}

TEST(ImageHeader, NamesHeifsWithoutAStillPictureOfItsKind) {
    std::string other = fixture("lossless.heic"), film = fixture("film.avif");
    other.replace(other.find("hvc1"), 4, "jpeg");
    film.replace(film.find("pitm"), 4, "free");
    for (const auto& [file, kind] : {std::pair{fixture("track.heic"), "an image sequence without a still picture"},
                                     std::pair{film, "an AVIF with an image sequence without a still picture"},
                                     std::pair{other, "a picture that is not coded in HEVC (jpeg)"}}) {
        const auto header = read_image_header(file, kMaxPixels);
        ASSERT_FALSE(header) << kind;
        EXPECT_EQ(header.error().code, ErrorCode::Unusable);
        EXPECT_NE(header.error().message.find(kind), std::string::npos) << header.error().message;
    }
}

TEST(ImageHeader, DescribesWhichFrameIsRead) {
    const auto described = [](const std::string& file) { return describe_frame(*read_image_header(file, kMaxPixels)); };
    EXPECT_EQ(described(fixture("grey.gif")), "");
    EXPECT_EQ(described(fixture("lossless.avif")), "");
    EXPECT_EQ(described(fixture("film.gif")), "the file has 2 frames: the first is used");
    EXPECT_EQ(described(fixture("film.avif")), "the file has 2 frames: the main picture is used");
    EXPECT_EQ(described(fixture("film.heic")), "the file has 2 frames: the main picture is used");
}

TEST(ImageHeader, EndsCyclicListsOfPages) {
    std::string file = fixture("lzw.tif");
    constexpr std::size_t kEntry = 12;
    const ByteReader reader(file, false);
    const std::uint32_t first = *reader.read(4, 4);
    const std::size_t next = first + 2 + kEntry * *reader.read(first, 2);
    file.replace(next, 4, file, 4, 4);
    EXPECT_EQ(read_image_header(file, kMaxPixels)->frames, 65'535U);
}

TEST(ImageHeader, RefusesTooManyPixels) {
    for (const auto* name : {"bomb.png", "bomb.webp", "bomb.gif", "bomb.bmp", "bomb.avif", "bomb.heic"}) {
        const auto header = read_image_header(fixture(name), 64'000'000);
        ASSERT_FALSE(header) << name;
        EXPECT_EQ(header.error().code, ErrorCode::LimitExceeded) << name;
        EXPECT_NE(header.error().message.find("max-pixels"), std::string::npos);
    }
    constexpr std::size_t kPixels = std::size_t{24} * 16;
    EXPECT_TRUE(read_image_header(fixture("grey.jpg"), kPixels));
    EXPECT_FALSE(read_image_header(fixture("grey.jpg"), kPixels - 1));
}

TEST(ImageHeader, RefusesOtherFormatsByName) {
    using namespace std::string_literals;
    const std::vector<std::pair<std::string, const char*>> others = {
        {"\0\0\0\x18"
         "ftypcrx \0\0\0\1crx isom"s,
         "a camera's raw file"},
        {"\xff\x0a\x12\x34", "JPEG XL"},
        {"\0\0\0\x0cjP  \r\n\x87\n"s, "JPEG 2000"},
        {"8BPS\0\1"s, "a Photoshop file"},
        {"\0\0\2\0\1\0"s, "a cursor"},
        {"P6\n4 4\n255\n"s, "PPM"},
        {"%PDF-1.4", "PDF"},
        {"<svg xmlns=", "SVG"},
        {"hello", "text"},
        {"BMW and other cars, and a text", "text"},
        {"\x89PNG\x1a\1", "a damaged PNG"},
        {"\x88PNG\x1a\1", "not a supported image"},
    };
    for (const auto& [bytes, name] : others) {
        const auto header = read_image_header(bytes, kMaxPixels);
        ASSERT_FALSE(header) << name;
        EXPECT_EQ(header.error().code, ErrorCode::Unsupported) << name;
        EXPECT_NE(header.error().message.find("this is "s + name), std::string::npos) << header.error().message;
        EXPECT_NE(header.error().message.find("the supported formats are PNG, JPEG, WebP, TIFF, GIF, BMP, AVIF and "
                                              "HEIC"),
                  std::string::npos);
    }
    EXPECT_EQ(read_image_header("", kMaxPixels).error().code, ErrorCode::Malformed);
}

TEST(ImageHeader, SurvivesFilesTruncatedAnywhere) {
    constexpr std::size_t kLongestSignature = 18;
    for (const auto* name : {"progressive.jpg", "lossy.webp", "lossless.webp", "orientation-6.webp", "palette.png",
                             "big-endian.tif", "tiled.tif", "grey.gif", "film.gif", "runs-4.bmp", "fields.bmp",
                             "lossless.avif", "film.avif", "lossless.heic", "film.heic"}) {
        const std::string file = fixture(name);
        for (std::size_t size = 1; size < file.size(); ++size) {
            const auto header = read_image_header(std::string_view(file).substr(0, size), kMaxPixels);
            if (header) {
                EXPECT_EQ(header->pixels(), 24U * 16U) << name << ' ' << size;
            } else {
                const bool may_be_other = size < kLongestSignature && header.error().code == ErrorCode::Unsupported;
                EXPECT_TRUE(may_be_other || header.error().code == ErrorCode::Unusable) << name << ' ' << size;
            }
        }
    }
}

TEST(ImageHeader, RefusesAvifsLargerThanTheCodecAllows) {
    std::string file = fixture("bomb.avif");
    const auto at = file.find("ispe") + 8;
    file.replace(at, 4, std::string("\0\1\0\1", 4));
    EXPECT_EQ(read_image_header(file, std::numeric_limits<std::size_t>::max()).error().code, ErrorCode::Unusable);
}

TEST(ImageHeader, FindsTheFrameOfAJpegAfterOtherSegments) {
    std::string file = fixture("grey.jpg");
    file.insert(
        2, std::string("\xff\xff\xff\xfe\x00\x04\xff\xc0", 8));  // fill bytes, and a comment that looks like a frame
    const auto header = read_image_header(file, kMaxPixels);
    ASSERT_TRUE(header);
    EXPECT_EQ(header->width, 24U);
}

TEST(ImageHeader, NamesJpegsThatTheDecoderDoesNotRead) {
    const auto refusal = [](char marker, char bits, char height = 8) {
        const std::string rest("\x00\x08\x01\x01\x11\x00", 6);
        const std::string file =
            std::string("\xff\xd8\xff") + marker + std::string("\x00\x0b", 2) + bits + '\0' + height + rest;
        const auto header = read_image_header(file, kMaxPixels);
        return header ? "" : header.error().message;
    };
    for (const char marker : {'\xc0', '\xc1', '\xc2', '\xc9', '\xca'}) EXPECT_EQ(refusal(marker, 8), "");
    for (const char marker : {'\xc3', '\xc5', '\xcb', '\xcf', '\xf7'})
        EXPECT_TRUE(refusal(marker, 8).ends_with("a JPEG with lossless or hierarchical coding")) << refusal(marker, 8);
    EXPECT_TRUE(refusal('\xc1', 12).ends_with("a JPEG with 12 bits per channel")) << refusal('\xc1', 12);
    EXPECT_TRUE(refusal('\xc0', 8, 0).ends_with("a JPEG that states its height after its rows (DNL)"));
}

TEST(ImageHeader, RefusesJpegsWithTooManyScans) {
    const std::string scan(
        "\xff\xda\x00\x02"
        "data\xff\x00more\xff\xd0 and more",
        25);
    const auto file_of = [&](int scans) {
        std::string file("\xff\xd8\xff\xc2\x00\x0b\x08\x00\x08\x00\x08\x01\x01\x11\x00", 15);
        for (int i = 0; i < scans; ++i) file += std::string("\xff\xff\xfe\x00\x04\xff\xda", 7) + scan;
        return file + "\xff\xd9" + scan;
    };
    EXPECT_TRUE(read_image_header(file_of(100), kMaxPixels));
    const auto refused = read_image_header(file_of(101), kMaxPixels);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unusable);
    EXPECT_NE(refused.error().message.find("100 scans"), std::string::npos);
}

TEST(ImageHeader, ReadsTheOrientationInExif) {
    EXPECT_EQ(exif_orientation(fixture("orientation-6.webp"), ImageFormat::WebP), 6);
    EXPECT_EQ(exif_orientation(fixture("orientation-6.png"), ImageFormat::Png), 6);
    EXPECT_EQ(exif_orientation(fixture("lossy.webp"), ImageFormat::WebP), 1);
    EXPECT_EQ(exif_orientation(fixture("noise.png"), ImageFormat::Png), 1);
    EXPECT_EQ(exif_orientation(fixture("grey.jpg"), ImageFormat::Jpeg), 1);
    for (int i = 1; i <= 8; ++i)
        EXPECT_EQ(exif_orientation(fixture("orientation-" + std::to_string(i) + ".jpg"), ImageFormat::Jpeg), i);
}

}  // namespace
}  // namespace ccdt::api
