// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/signed_url.h"

#include <gtest/gtest.h>

#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

using std::chrono::seconds;

const std::string kKey = "0123456789abcdef0123456789abcdef";

/// Returns the status of the check of a URL; 200 if the signature is valid.
int status(const std::string& resource, std::int64_t now = 1000) {
    const auto keys = KeyRing::parse("old:" + kKey + "\nnew:" + kKey + "B");
    const auto checked = SignedUrl::parse(resource).and_then(
        [&](const SignedUrl& url) { return url.check(*keys, std::chrono::sys_seconds(seconds(now))); });
    return checked ? 200 : checked.error().status;
}

std::string with_signature(const std::string& text, const std::string& key = kKey) {
    return text + (text.find('?') == std::string::npos ? '?' : '&') + "signature=" + sign(key, text);
}

TEST(SignedUrl, AcceptsSignaturesOfAnyKey) {
    for (const char* text : {"/halftone/cat.jpg", "/halftone/cat.jpg?sites=500", "/halftone/%C3%A4.png?a=b&c=%26",
                             "/halftone/a&signature=b", "/halftone/x?", "/halftone/x?a=b&signature=c"}) {
        EXPECT_EQ(status(with_signature(text)), 200) << text;
        EXPECT_EQ(status(with_signature(text, kKey + "B")), 200) << text;
        EXPECT_EQ(status(with_signature(text, kKey + "C")), 403) << text;
    }
}

TEST(SignedUrl, RefusesAnyOtherUrlThanTheSignedOne) {
    const std::string good = with_signature("/halftone/cat.jpg?sites=500");
    ASSERT_EQ(status(good), 200);
    for (std::size_t i = 0; i < good.size(); ++i) {
        std::string other = good;
        other[i] = other[i] == 'x' ? 'y' : 'x';
        EXPECT_EQ(status(other), 403) << other;
        EXPECT_EQ(status(good.substr(0, i)), 403) << i;
    }
    for (const char* more : {"=", "%3D", "&", "&seed=1", "&signature=", " ", "A"})
        EXPECT_EQ(status(good + more), 403) << more;
}

TEST(SignedUrl, RequiresTheSignatureAsTheLastParameter) {
    const std::string text = "/halftone/cat.jpg", signature = "signature=" + sign(kKey, text);
    EXPECT_EQ(status(text + '?' + signature), 200);
    for (const auto& url :
         {text, text + '?', text + '&' + signature, text + ';' + signature, text + "?a=b",
          text + '?' + signature + "&a=b", text + "?s" + signature, text + "?%73" + signature.substr(1),
          text + "?Signature=" + sign(kKey, text), std::string(), std::string("?")})
        EXPECT_EQ(status(url), 403) << url;
}

TEST(SignedUrl, Expires) {
    const std::string url = with_signature("/halftone/cat.jpg?expires=2000&sites=5");
    EXPECT_EQ(status(url, 1999), 200);
    EXPECT_EQ(status(url, 2000), 403);
    EXPECT_EQ(status(with_signature("/x?expires=18446744073709551615"), 1LL << 60), 200);
    EXPECT_EQ(status(with_signature("/x?expires=0"), 0), 403);
    for (const char* wrong : {"expires=", "expires=-1", "expires=1.5", "expires=18446744073709551616", "expires=%31",
                              "expires=1&expires=1", "expires=+5"})
        EXPECT_EQ(status(with_signature("/x?" + std::string(wrong))), 400) << wrong;
}

TEST(SignedUrl, ReturnsTheRemainingOptions) {
    const auto options = [](const char* resource) { return SignedUrl::parse(resource)->options; };
    EXPECT_EQ(options("/x"), "");
    EXPECT_EQ(options("/x?signature=a"), "");
    EXPECT_EQ(options("/x?expires=1&signature=a"), "");
    EXPECT_EQ(options("/x?sites=5&expires=1&seed=2&signature=a"), "sites=5&seed=2");
    EXPECT_EQ(options("/x?signature=a&sites=5"), "signature=a&sites=5") << "is refused as an unknown option";
    EXPECT_EQ(options("/x?expired=1&expires"), "expired=1&expires");
}

}  // namespace
}  // namespace ccdt::server
