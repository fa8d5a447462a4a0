// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/embedded_image.h"

#include <gtest/gtest.h>

#include "api/text/base64.h"
#include "tests/api/files.h"

namespace ccdt::api {
namespace {

Input text(std::string_view value) {
    return {"image", "/image", value};
}

TEST(Base64, DecodesTheTestVectorsOfTheRfc) {
    EXPECT_EQ(*decode_base64(""), "");
    EXPECT_EQ(*decode_base64("Zg=="), "f");
    EXPECT_EQ(*decode_base64("Zm8="), "fo");
    EXPECT_EQ(*decode_base64("Zm9v"), "foo");
    EXPECT_EQ(*decode_base64("Zm9vYg=="), "foob");
    EXPECT_EQ(*decode_base64("Zm9vYmE="), "fooba");
    EXPECT_EQ(*decode_base64("Zm9vYmFy"), "foobar");
    EXPECT_EQ(*decode_base64("+/8A"), std::string("\xfb\xff\0", 3));
}

TEST(Base64, DecodesItsEncoding) {
    for (const std::string& bytes : {std::string(), std::string("f"), std::string("fo"), std::string("\xfb\xff\0", 3)})
        EXPECT_EQ(*decode_base64(base64(bytes)), bytes);
    EXPECT_EQ(base64("foob"), "Zm9vYg==");
}

TEST(Base64, AcceptsMissingPadding) {
    EXPECT_EQ(*decode_base64("Zg"), "f");
    EXPECT_EQ(*decode_base64("Zm8"), "fo");
}

TEST(Base64, IgnoresBlanksAndLineBreaks) {
    for (const auto* spaced : {"Zm9v\nYg==\n", " Zm9 vY\tg==", "Zm9v\r\nYg=\r\n=", "Zm9vYg\n"})
        EXPECT_EQ(decode_base64(spaced).value_or("refused"), "foob") << spaced;
}

TEST(Base64, RefusesInvalidEncodings) {
    for (const auto* wrong : {"Z", "Zg=", "Zg===", "Z===", "=", "====", "Zm9v=", "Zh==", "Zm9=", "Zm 9", "Zm9v\v",
                              "Z\ng\n=", " Z ", "Zm-_", "Zg==Zg==", "Zm9vY"}) {
        EXPECT_FALSE(decode_base64(wrong)) << wrong;
    }
}

TEST(EmbeddedImage, ReadsBase64AndDataUris) {
    const std::string png = fixture("grey-16.png");
    for (const auto* scheme : {"", "data:image/png;base64,", "data:;base64,"}) {
        const auto image = read_embedded_image(text(scheme + base64(png)), {});
        ASSERT_TRUE(image) << scheme << ": " << image.error().message;
        EXPECT_EQ(image->bytes, png);
        EXPECT_EQ(image->header.width, 24U);
    }
}

TEST(EmbeddedImage, RefusesTextThatIsNotBase64OrADataUri) {
    for (const auto* wrong :
         {"", "!", "data:", "data:image/png,abc", "data:image/png;base64", "http://localhost/a.png"}) {
        const auto image = read_embedded_image(text(wrong), {});
        ASSERT_FALSE(image) << wrong;
        EXPECT_EQ(image.error().code, ErrorCode::Malformed) << wrong;
        EXPECT_EQ(image.error().field, "/image");
    }
}

TEST(EmbeddedImage, RefusesTooManyPixels) {
    const std::string picture = base64(fixture("grey-16.png"));
    const auto image = read_embedded_image(text(picture), {.max_pixels = 100});
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::LimitExceeded);
    EXPECT_EQ(image.error().field, "/image");
}

TEST(EmbeddedImage, RefusesOtherFormats) {
    const auto image = read_embedded_image(text(base64("not an image")), {});
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::Unsupported);
    EXPECT_EQ(image.error().field, "/image");
}

}  // namespace
}  // namespace ccdt::api
