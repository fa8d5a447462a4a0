// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/pen_labels.h"

#include <gtest/gtest.h>

namespace ccdt::api {
namespace {

std::vector<std::string> labels_of(std::vector<Ink> inks) {
    return pen_labels(inks);
}

using Labels = std::vector<std::string>;

TEST(PenLabels, AreTheNamesOfInks) {
    EXPECT_EQ(labels_of({{"cyan", {0, 255, 255}}, {"black", kBlack}}), (Labels{"cyan", "black"}));
    EXPECT_EQ(labels_of({{"", kBlack}}), Labels{"dots"});
}

TEST(PenLabels, AreColourWordsForUnnamedInks) {
    EXPECT_EQ(
        labels_of({{"#ff0000", {255, 0, 0}}, {"#00ff00", {0, 255, 0}}, {"#0000ff", {0, 0, 255}}, {"#000000", kBlack}}),
        (Labels{"red", "lime", "blue", "black"}));
    EXPECT_EQ(labels_of({{"#fe0102", {254, 1, 2}}}), Labels{"red"});
}

TEST(PenLabels, HaveNoDigits) {
    EXPECT_EQ(labels_of({{"people of 2020", kBlack}, {"7", kBlack}}), (Labels{"people of", "black"}));
}

TEST(PenLabels, AreDistinct) {
    EXPECT_EQ(labels_of({{"#ff0000", {255, 0, 0}}, {"#fe0000", {254, 0, 0}}, {"#000000", kBlack}}),
              (Labels{"red A", "red B", "black"}));
    EXPECT_EQ(labels_of({{"pop2010", kBlack}, {"pop2020", kWhite}}), (Labels{"pop A", "pop B"}));
}

}  // namespace
}  // namespace ccdt::api
