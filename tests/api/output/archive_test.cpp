// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/archive.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/api/output/whole_body.h"

namespace ccdt::api {
namespace {

TEST(Archive, IsReadAsWritten) {
    const std::vector<ArchivedFile> files = {
        {"cyan.svg", "123456789"}, {"empty", ""}, {"x", std::string(70'000, '\xff')}};
    const std::string archive = test::whole_body([&](Body& body) { EXPECT_TRUE(write_archive(files, body)); });
    const auto read = read_archive(archive);
    ASSERT_EQ(read.size(), files.size());
    for (std::size_t i = 0; i < files.size(); ++i) {
        EXPECT_EQ(read[i].name, files[i].name);
        EXPECT_EQ(read[i].bytes, files[i].bytes);
    }
    EXPECT_EQ(archive.substr(14, 4), "\x26\x39\xf4\xcb") << "the check value of the checksum";
    EXPECT_EQ(archive.substr(archive.size() - 22, 4), "PK\x05\x06");
}

}  // namespace
}  // namespace ccdt::api
