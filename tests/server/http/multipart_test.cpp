#include "server/http/multipart.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

constexpr const char* kType = "multipart/form-data; boundary=XX";

TEST(Multipart, FindsThePartsOfAForm) {
    const std::string body =
        "--XX\r\nContent-Disposition: form-data; name=\"image\"; filename=\"a.png\"\r\n"
        "Content-Type: image/png\r\n\r\nbinary\r\n--X\r\n\r\nmore\r\n"
        "--XX\r\ncontent-disposition: form-data; name=sites\r\n\r\n20\r\n"
        "--XX\r\nContent-Disposition: form-data; name=\"empty\"\r\n\r\n\r\n--XX--\r\n";
    const auto parts = parse_multipart(body, kType);
    ASSERT_TRUE(parts) << parts.error().detail;
    ASSERT_EQ(parts->size(), 3u);
    EXPECT_EQ((*parts)[0].name, "image");
    EXPECT_EQ((*parts)[0].content(body), "binary\r\n--X\r\n\r\nmore");
    EXPECT_EQ((*parts)[1].name, "sites");
    EXPECT_EQ((*parts)[1].content(body), "20");
    EXPECT_EQ((*parts)[2].name, "empty");
    EXPECT_EQ((*parts)[2].content(body), "");
}

TEST(Multipart, ReadsAFormWithoutParts) {
    const auto parts = parse_multipart("--XX--\r\n", kType);
    ASSERT_TRUE(parts);
    EXPECT_TRUE(parts->empty());
}

TEST(Multipart, RefusesWhatIsCutOff) {
    const std::string body = "--XX\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\nvalue\r\n--XX--";
    ASSERT_TRUE(parse_multipart(body, kType));
    for (std::size_t size = 0; size < body.size(); ++size)
        EXPECT_FALSE(parse_multipart(body.substr(0, size), kType)) << size;
}

TEST(Multipart, RefusesFormsWithoutBoundaryOrNames) {
    EXPECT_FALSE(parse_multipart("--XX--", "multipart/form-data"));
    EXPECT_FALSE(parse_multipart("--YY--", kType));
    EXPECT_FALSE(parse_multipart("--XX\r\nContent-Type: text/plain\r\n\r\nvalue\r\n--XX--", kType));
    EXPECT_FALSE(parse_multipart("--XX\r\n\r\nvalue\r\n--XX--", kType));
}

}  // namespace
}  // namespace ccdt::server
