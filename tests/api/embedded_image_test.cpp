#include "api/embedded_image.h"

#include <gtest/gtest.h>

#include "tests/api/files.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kGif = "R0lGODlhAQABAIAAAAAAAP///ywAAAAAAQABAAACAkQBADs=";
constexpr std::string_view kPngStart = "iVBORw0KGgo=";

Input text(std::string_view value) {
    return {"image", "/image", value};
}

TEST(Base64, DecodesTheVectorsOfTheRfc) {
    EXPECT_EQ(*decode_base64(""), "");
    EXPECT_EQ(*decode_base64("Zg=="), "f");
    EXPECT_EQ(*decode_base64("Zm8="), "fo");
    EXPECT_EQ(*decode_base64("Zm9v"), "foo");
    EXPECT_EQ(*decode_base64("Zm9vYg=="), "foob");
    EXPECT_EQ(*decode_base64("Zm9vYmE="), "fooba");
    EXPECT_EQ(*decode_base64("Zm9vYmFy"), "foobar");
    EXPECT_EQ(*decode_base64("+/8A"), std::string("\xfb\xff\0", 3));
}

TEST(Base64, TakesMissingPadding) {
    EXPECT_EQ(*decode_base64("Zg"), "f");
    EXPECT_EQ(*decode_base64("Zm8"), "fo");
}

TEST(Base64, RefusesWhatNoEncoderWrites) {
    for (const auto* wrong : {"Z", "Zg=", "Zg===", "Z===", "=", "====", "Zm9v=", "Zh==", "Zm9=", "Zm 9", "Zm9v\n",
                              "Zm-_", "Zg==Zg==", "Zm9vY"}) {
        EXPECT_FALSE(decode_base64(wrong)) << wrong;
    }
}

TEST(EmbeddedImage, ReadsBase64AndDataUris) {
    const std::string png = "\x89PNG\r\n\x1a\n";
    EXPECT_EQ(*read_embedded_image(text(kPngStart)), png);
    EXPECT_EQ(*read_embedded_image(text("data:image/png;base64," + std::string(kPngStart))), png);
    EXPECT_EQ(*read_embedded_image(text("data:;base64," + std::string(kPngStart))), png);
}

TEST(EmbeddedImage, RefusesOtherTexts) {
    for (const auto* wrong :
         {"", "!", "data:", "data:image/png,abc", "data:image/png;base64", "http://localhost/a.png"}) {
        const auto image = read_embedded_image(text(wrong));
        ASSERT_FALSE(image) << wrong;
        EXPECT_EQ(image.error().code, ErrorCode::Malformed) << wrong;
        EXPECT_EQ(image.error().field, "/image");
    }
}

TEST(EmbeddedImage, RefusesOtherFormats) {
    const auto image = read_embedded_image(text(kGif));
    ASSERT_FALSE(image);
    EXPECT_EQ(image.error().code, ErrorCode::Unsupported);
    EXPECT_EQ(image.error().field, "/image");
}

}  // namespace
}  // namespace ccdt::api
