// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/trace.h"

#include <gtest/gtest.h>

#include <string>

namespace ccdt::server {
namespace {

const std::string kId = "0af7651916cd43dd8448eb211c80319c";
const std::string kParent = "b7ad6b7169203331";
const std::string kHeader = "00-" + kId + "-" + kParent + "-01";

TEST(ParseTraceparent, ReadsTraceAndParent) {
    for (const std::string& header :
         {kHeader, "01" + kHeader.substr(2), "cc" + kHeader.substr(2) + "-what-comes-later"}) {
        const auto trace = parse_traceparent(header);
        ASSERT_TRUE(trace) << header;
        EXPECT_EQ(trace->id, kId);
        EXPECT_EQ(trace->parent, kParent);
    }
}

TEST(ParseTraceparent, RefusesMalformedHeaders) {
    for (const std::string& header :
         {std::string(), kHeader.substr(1), kHeader + "-x", kHeader + "x", "ff" + kHeader.substr(2),
          "0G" + kHeader.substr(2), "01" + kHeader.substr(2) + "x",
          "00-" + std::string(32, '0') + "-" + kParent + "-01", "00-" + kId + "-" + std::string(16, '0') + "-01",
          "00-" + kId + "-" + kParent + "-0X", "00-" + std::string(32, 'A') + "-" + kParent + "-01",
          "00_" + kHeader.substr(3)})
        EXPECT_FALSE(parse_traceparent(header)) << header;
}

TEST(WholeTraceparent, RoundTrips) {
    EXPECT_EQ(whole_traceparent(kHeader), kHeader);
    const std::string later = "cc" + kHeader.substr(2);
    EXPECT_EQ(whole_traceparent(later + "-what-comes-later"), later);
    EXPECT_EQ(parse_traceparent(later)->id, kId);
    EXPECT_EQ(whole_traceparent(kHeader + "-x"), "");
}

}  // namespace
}  // namespace ccdt::server
