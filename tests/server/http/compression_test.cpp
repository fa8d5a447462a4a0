// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/compression.h"

#include <gtest/gtest.h>
#include <zlib.h>

namespace ccdt::server {
namespace {

std::string unpack(const std::string& compressed, std::size_t size) {
    std::string text(size + 1, '\0');
    z_stream stream{};
    EXPECT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);
    std::string input = compressed;
    stream.next_in = reinterpret_cast<Bytef*>(input.data());
    stream.avail_in = static_cast<uInt>(input.size());
    stream.next_out = reinterpret_cast<Bytef*>(text.data());
    stream.avail_out = static_cast<uInt>(text.size());
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
    text.resize(stream.total_out);
    inflateEnd(&stream);
    return text;
}

TEST(Gzip, CompressesTextLosslessly) {
    std::string text;
    for (int i = 0; i < 200'000; ++i) text += std::to_string(i * 7919 % 10'007) + ",";
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{262'144}, std::size_t{524'289}, text.size()}) {
        const auto compressed = gzip(std::string_view(text).substr(0, size));
        ASSERT_TRUE(compressed);
        EXPECT_EQ(unpack(*compressed, size), text.substr(0, size));
        EXPECT_LT(compressed->size(), size / 2 + 100);
    }
}

TEST(Gzip, StopsOnRequest) {
    std::stop_source stop;
    stop.request_stop();
    EXPECT_FALSE(gzip("text", stop.get_token()));
}

TEST(AcceptsGzip, ComparesQualities) {
    for (const char* header : {"gzip", "x-gzip", "GZIP", "br, gzip", "gzip;q=0.001", "deflate;q=1, gzip; q=0.5", "*",
                               "br;q=1.0,*;q=0.1", "gzip;q=0.5, identity;q=0.4", "identity;q=0, gzip;Q=1"})
        EXPECT_TRUE(accepts_gzip(header)) << header;
    for (const char* header : {"", "br", "identity", "gzip;q=0", "gzip;q=0.0, *", "*;q=0", "gzip;q=0.4, identity;q=0.5",
                               "gzip;q=", "gzip;q=one", "gzipped", ";q=1", ",,,"})
        EXPECT_FALSE(accepts_gzip(header)) << header;
}

TEST(IsWorthCompressing, AcceptsLongTextsOnly) {
    const std::string body(1025, 'x');
    for (const char* type : {"application/json", "application/problem+json", "image/svg+xml", "text/csv",
                             "application/geo+json", "text/html; charset=utf-8"})
        EXPECT_TRUE(is_worth_compressing(type, body)) << type;
    for (const char* type : {"image/png", "application/octet-stream", "text/event-stream", ""})
        EXPECT_FALSE(is_worth_compressing(type, body)) << type;
    EXPECT_FALSE(is_worth_compressing("application/json", body.substr(1)));
}

}  // namespace
}  // namespace ccdt::server
