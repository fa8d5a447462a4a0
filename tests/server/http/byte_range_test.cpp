// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/byte_range.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

TEST(ByteRange, IsWithinTheBody) {
    EXPECT_EQ(parse_range("bytes=0-0", 10), (ByteRange{0, 1}));
    EXPECT_EQ(parse_range("bytes=3-5", 10), (ByteRange{3, 3}));
    EXPECT_EQ(parse_range("bytes=3-", 10), (ByteRange{3, 7}));
    EXPECT_EQ(parse_range("bytes=3-99", 10), (ByteRange{3, 7}));
    EXPECT_EQ(parse_range("bytes=-4", 10), (ByteRange{6, 4}));
    EXPECT_EQ(parse_range("bytes=-99", 10), (ByteRange{0, 10}));
    EXPECT_EQ(parse_range("bytes= 3 - 5 ", 10), (ByteRange{3, 3}));
}

TEST(ByteRange, IsEmptyBeyondTheBody) {
    EXPECT_EQ(parse_range("bytes=10-", 10)->length, 0U);
    EXPECT_EQ(parse_range("bytes=-0", 10)->length, 0U);
    EXPECT_EQ(parse_range("bytes=0-", 0)->length, 0U);
}

TEST(ByteRange, IgnoresOtherHeaders) {
    for (const auto* header : {"", "bytes", "bytes=", "bytes=-", "bytes=5-3", "bytes=0-1,3-4", "bytes=a-b", "bytes=1-b",
                               "bytes=--1", "lines=0-1", "bytes=99999999999999999999-"})
        EXPECT_EQ(parse_range(header, 10), std::nullopt) << header;
}

}  // namespace
}  // namespace ccdt::server
