// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/fair_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace ccdt::server {
namespace {

TEST(FairQueue, ForgetsClientsOnceItIsEmpty) {
    FairQueue<char> queue;
    queue.push("costly", 1000, 'x');
    EXPECT_EQ(queue.take_next(), 'x');
    queue.push("costly", 1, 'a');
    queue.push("cheap", 1, 'b');
    queue.push("costly", 1, 'c');
    queue.push("cheap", 1, 'd');
    std::string order;
    while (!queue.empty()) order += queue.take_next();
    EXPECT_EQ(order, "abcd");
}

TEST(FairQueue, DoesNotChargeForWithdrawnItems) {
    FairQueue<char> queue;
    queue.push("a", 1, 'x');
    queue.push("a", 1000, 'y');
    EXPECT_EQ(queue.withdraw([](char item) { return item == 'y'; }), 'y');
    EXPECT_FALSE(queue.withdraw([](char item) { return item == 'y'; }));
    queue.push("b", 2, 'b');
    queue.push("a", 1, 'c');
    queue.push("b", 1, 'd');
    std::string order;
    while (!queue.empty()) order += queue.take_next();
    EXPECT_EQ(order, "xbcd");
}

TEST(FairQueue, CorrectsTheCostOfTakenItems) {
    FairQueue<char> queue;
    queue.push("low", 1, 'x');
    queue.push("high", 5, 'y');
    for (const char item : {'a', 'b'}) queue.push("low", 1, item);
    for (const char item : {'c', 'd'}) queue.push("high", 1, item);
    EXPECT_EQ(queue.take_next(), 'x');
    EXPECT_EQ(queue.take_next(), 'y');
    queue.charge("low", 0, 1, 10);
    queue.charge("high", 0, 5, 1);
    std::string order;
    while (!queue.empty()) order += queue.take_next();
    EXPECT_EQ(order, "cdab");
}

TEST(FairQueue, ChargesClientsWithoutItems) {
    FairQueue<char> queue;
    queue.push("idle", 1, 'x');
    for (const char item : {'a', 'b', 'c'}) queue.push("other", 1, item);
    EXPECT_EQ(queue.take_next(), 'x');
    queue.charge("idle", 0, 1, 10);
    queue.push("idle", 1, 'd');
    std::string order;
    while (!queue.empty()) order += queue.take_next();
    EXPECT_EQ(order, "abcd");
}

TEST(FairQueue, DoesNotRefundForgottenEstimates) {
    FairQueue<char> queue;
    queue.push("a", 5, 'x');
    EXPECT_EQ(queue.take_next(), 'x');
    for (const char item : {'b', 'c'}) queue.push("b", 1, item);
    queue.push("a", 1, 'a');
    queue.charge("a", 0, 5, 3);
    std::string order;
    while (!queue.empty()) order += queue.take_next();
    EXPECT_EQ(order, "bca");
}

TEST(FairQueue, ReturnsItemsToTheFront) {
    FairQueue<char> queue;
    for (const char item : {'a', 'b', 'c'}) queue.push("one", 1, item);
    auto taken = queue.take_next_of([](char item) { return item != 'a'; });
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->item, 'b');
    EXPECT_FALSE(queue.take_next_of([](char item) { return item == 'b'; }));
    queue.push("two", 1, 'd');
    EXPECT_EQ(queue.take_next(), 'a');
    queue.put_back(*taken);
    std::string order;
    while (!queue.empty()) order += queue.take_next();
    EXPECT_EQ(order, "bdc");
}

}  // namespace
}  // namespace ccdt::server
