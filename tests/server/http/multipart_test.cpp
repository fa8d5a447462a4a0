// SPDX-License-Identifier: GPL-3.0-or-later
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
    ASSERT_TRUE(parts) << parts.error().error.message;
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

TEST(Multipart, RefusesTruncatedForms) {
    const std::string body = "--XX\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\nvalue\r\n--XX--";
    ASSERT_TRUE(parse_multipart(body, kType));
    for (std::size_t size = 0; size < body.size(); ++size)
        EXPECT_FALSE(parse_multipart(body.substr(0, size), kType)) << size;
}

TEST(Multipart, SkipsThePreamble) {
    const std::string part = "--XX \t\r\nContent-Disposition: form-data; name=a\r\n\r\nb\r\n--XX--";
    const std::string body = "no--XX\r\n" + part;
    const auto parts = parse_multipart(body, kType);
    ASSERT_TRUE(parts) << parts.error().error.message;
    ASSERT_EQ(parts->size(), 1u);
    EXPECT_EQ(parts->front().content(body), "b");
    EXPECT_TRUE(parse_multipart("no" + part, kType)->empty()) << "a boundary begins a line";
}

/// Parses a form that has one part and the given boundary.
HttpResult<std::vector<FormPart>> parse_with(const std::string& boundary) {
    const std::string body =
        "--" + boundary + "\r\nContent-Disposition: form-data; name=a\r\n\r\nb\r\n--" + boundary + "--";
    return parse_multipart(body, "multipart/form-data; boundary=\"" + boundary + '"');
}

TEST(Multipart, AcceptsOnlyValidBoundaries) {
    for (const std::string& boundary : {std::string("x"), std::string(70, '-'), std::string("'()+_,-./:=? aZ09")})
        EXPECT_TRUE(parse_with(boundary)) << boundary;
    const std::string dashes(30'000, '-');
    for (const std::string& boundary : {std::string(71, 'x'), dashes + 'x', std::string("x "), std::string("a@b"),
                                        std::string("a\xe9"), std::string("a\tb")}) {
        const auto parts = parse_with(boundary);
        ASSERT_FALSE(parts) << boundary;
        EXPECT_EQ(parts.error().status, 400);
        EXPECT_NE(parts.error().error.message.find("1 to 70"), std::string::npos) << parts.error().error.message;
    }
}

TEST(Multipart, LimitsPartsAndTheirHeaders) {
    const auto form = [](int parts, std::size_t padding) {
        std::string body;
        for (int i = 0; i < parts; ++i)
            body +=
                "--XX\r\nX: " + std::string(padding, '\r') + "\r\nContent-Disposition: form-data; name=a\r\n\r\n\r\n";
        return body + "--XX--";
    };
    EXPECT_EQ(parse_multipart(form(1000, 0), kType)->size(), 1000u);
    EXPECT_NE(parse_multipart(form(1001, 0), kType).error().error.message.find("1000"), std::string::npos);
    EXPECT_EQ(parse_multipart(form(1, 16'000), kType)->size(), 1u);
    EXPECT_NE(parse_multipart(form(1, 20'000), kType).error().error.message.find("16384"), std::string::npos);
}

TEST(Multipart, RefusesTextAfterABoundary) {
    EXPECT_FALSE(parse_multipart("--XXY\r\nContent-Disposition: form-data; name=a\r\n\r\nb\r\n--XX--", kType));
    EXPECT_FALSE(parse_multipart("--XX\nContent-Disposition: form-data; name=a\r\n\r\nb\r\n--XX--", kType));
}

TEST(Multipart, RefusesPartsWithSeveralDispositions) {
    const std::string one = "Content-Disposition: form-data; name=a\r\n";
    const std::string other = "content-disposition: form-data; name=b\r\n";
    EXPECT_TRUE(parse_multipart("--XX\r\n" + one + "\r\n1\r\n--XX--", kType));
    const auto parts = parse_multipart("--XX\r\n" + one + other + "\r\n1\r\n--XX--", kType);
    ASSERT_FALSE(parts);
    EXPECT_EQ(parts.error().status, 400);
}

TEST(Multipart, RefusesRepeatedParameters) {
    const auto part = [](const std::string& parameters) {
        return "--XX\r\nContent-Disposition: form-data; " + parameters + "\r\n\r\n1\r\n--XX--";
    };
    EXPECT_TRUE(parse_multipart(part("name=a; filename=b"), kType));
    EXPECT_FALSE(parse_multipart(part("name=a; name=b"), kType));
    EXPECT_FALSE(parse_multipart(part("name=a; Name=\"a\""), kType));
    EXPECT_FALSE(parse_multipart(part("name=a"), "multipart/form-data; boundary=XX; boundary=YY"));
}

TEST(Multipart, RefusesFormsWithoutBoundaryOrNames) {
    EXPECT_FALSE(parse_multipart("--XX--", "multipart/form-data"));
    EXPECT_FALSE(parse_multipart("--YY--", kType));
    EXPECT_FALSE(parse_multipart("--XX\r\nContent-Type: text/plain\r\n\r\nvalue\r\n--XX--", kType));
    EXPECT_FALSE(parse_multipart("--XX\r\n\r\nvalue\r\n--XX--", kType));
}

}  // namespace
}  // namespace ccdt::server
