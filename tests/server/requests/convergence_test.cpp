// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/convergence.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

api::Answer answer_with(std::size_t sites) {
    api::Answer answer;
    answer.sites = sites;
    return answer;
}

TEST(DoubtAbout, NamesTheVariationOfARunThatDidNotConverge) {
    EXPECT_EQ(doubt_about(answer_with(1'000), "/sample", 5, 1.5),
              "1000 sites of /sample have a capacity variation of 1.5 after 5 iterations");
}

TEST(DoubtAbout, IsEmptyForOtherRuns) {
    EXPECT_EQ(doubt_about(answer_with(1'000), "/sample", 5, .5), "");
    EXPECT_EQ(doubt_about(answer_with(1'000), "/sample", 4, 1.5), "");
    EXPECT_EQ(doubt_about(answer_with(999), "/sample", 5, 1.5), "");
    EXPECT_EQ(doubt_about(answer_with(1'000), "/halftone", 5, 1.5), "");
    api::Answer partial = answer_with(1'000);
    partial.partial = true;
    EXPECT_EQ(doubt_about(partial, "/sample", 5, 1.5), "");
}

}  // namespace
}  // namespace ccdt::server
