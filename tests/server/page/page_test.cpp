// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/page/page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace ccdt::server {
namespace {

std::string header(const Response& response, std::string_view name) {
    const auto found = std::ranges::find(response.headers, name, &Header::name);
    return found == response.headers.end() ? "" : found->value;
}

TEST(Page, ServesItsFilesWithTheirTypes) {
    ASSERT_NE(find_page_file("/"), nullptr);
    EXPECT_TRUE(find_page_file("/")->content.starts_with("<!doctype html>"));
    EXPECT_EQ(find_page_file("/")->media_type, "text/html; charset=utf-8");
    EXPECT_EQ(find_page_file("/assets/main.js")->media_type, "text/javascript; charset=utf-8");
    EXPECT_EQ(find_page_file("/assets/samples/cat.jpg")->media_type, "image/jpeg");
    EXPECT_TRUE(find_page_file("/assets/samples/cat.jpg")->content.starts_with("\xff\xd8\xff"));
    for (const char* path : {"", "/index.html", "/assets", "/assets/", "/assets/index.html", "/assets/../config.h"})
        EXPECT_EQ(find_page_file(path), nullptr) << path;
}

TEST(Document, HasTheTypeOfItsSuffix) {
    EXPECT_EQ(document_type("a/b.html"), "text/html; charset=utf-8");
    EXPECT_EQ(document_type("b.min.js"), "text/javascript; charset=utf-8");
    EXPECT_EQ(document_type("b.svg"), "image/svg+xml");
    for (const char* path : {"", "html", "a.html/b", "b.HTML", "b.gif"})
        EXPECT_EQ(document_type(path), "application/octet-stream") << path;
}

TEST(Document, HasAnEntityTagOfItsContent) {
    const Response response = document_response("a.txt", "text", "");
    EXPECT_EQ(response.body, "text");
    EXPECT_EQ(response.media_type, "text/plain; charset=utf-8");
    EXPECT_EQ(document_response("b.txt", "text", "").tag, response.tag);
    EXPECT_NE(document_response("a.txt", "texts", "").tag, response.tag);
    EXPECT_EQ(document_response("a.txt", "text", response.tag).status, 304);
    EXPECT_EQ(document_response("a.txt", "texts", response.tag).status, 200);
}

TEST(Page, ForbidsExternalContent) {
    const auto response = page_response(*find_page_file("/"), "");
    const auto policy = header(response, "Content-Security-Policy");
    EXPECT_TRUE(policy.starts_with("default-src 'none';"));
    EXPECT_EQ(policy.find("unsafe"), std::string::npos);
    EXPECT_EQ(header(response, "X-Content-Type-Options"), "nosniff");
}

TEST(Page, AnswersNotModifiedIfUnchanged) {
    const PageFile& file = *find_page_file("/");
    const Response whole = page_response(file, "");
    EXPECT_EQ(whole.status, 200);
    EXPECT_EQ(whole.body, file.content);
    const std::string tag = whole.tag;
    EXPECT_EQ(tag, '"' + std::string(file.digest) + '"');
    const std::string packed = tag.substr(0, tag.size() - 1) + "-gzip\"";
    for (const std::string& known : {tag, "W/" + tag, packed, "\"a\", " + tag, std::string("*")}) {
        const Response response = page_response(file, known);
        EXPECT_EQ(response.status, 304) << known;
        EXPECT_TRUE(response.body.empty());
        EXPECT_NE(known.find(known == "*" ? "*" : response.tag), std::string::npos);
    }
    const std::string other = page_response(*find_page_file("/assets/main.js"), "").tag;
    for (const std::string& unknown : {other, std::string("W/"), std::string("\"\""), tag.substr(0, tag.size() - 1)})
        EXPECT_EQ(page_response(file, unknown).status, 200) << unknown;
}

}  // namespace
}  // namespace ccdt::server
