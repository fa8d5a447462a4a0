// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/entity_tag.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

TEST(EntityTag, IsFoundInAList) {
    const auto found = [](std::string_view list) { return find_tag(list, "abc").value_or("none"); };
    EXPECT_EQ(found("\"abc\""), "\"abc\"");
    EXPECT_EQ(found("W/\"abc\""), "W/\"abc\"");
    EXPECT_EQ(found("\"abc-gzip\""), "\"abc-gzip\"");
    EXPECT_EQ(found("\"x\", \"abc\""), "\"abc\"");
    EXPECT_EQ(found("W/\"x\" ,W/\"abc\" , *"), "W/\"abc\"");
    for (const auto* list : {"", "*", "abc", "\"abcd\"", "\"ab\"", "\"", "W/", "\"x\"", "\"-gzip\"", "\"abc\"-gzip"})
        EXPECT_EQ(found(list), "none") << list;
}

}  // namespace
}  // namespace ccdt::server
