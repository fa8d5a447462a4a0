#include "server/http/capacity.h"

#include <gtest/gtest.h>

namespace ccdt::server {
namespace {

using Entry = Capacity::Entry;

TEST(Capacity, LimitsConnectionsInAll) {
    Capacity capacity({.connections = 2, .per_address = 0});
    EXPECT_EQ(capacity.enter("a"), Entry::Admitted);
    EXPECT_EQ(capacity.enter("a"), Entry::Admitted);
    EXPECT_EQ(capacity.enter("b"), Entry::Full);
    capacity.leave("a");
    EXPECT_EQ(capacity.enter("b"), Entry::Admitted);
    EXPECT_EQ(capacity.counts().open, 2u);
    EXPECT_EQ(capacity.counts().refused, 1u);
}

TEST(Capacity, LimitsConnectionsOfAnAddress) {
    Capacity capacity({.connections = 10, .per_address = 1});
    EXPECT_EQ(capacity.enter("a"), Entry::Admitted);
    EXPECT_EQ(capacity.enter("a"), Entry::AddressFull);
    EXPECT_EQ(capacity.enter("b"), Entry::Admitted);
    capacity.leave("a");
    EXPECT_EQ(capacity.enter("a"), Entry::Admitted);
    EXPECT_EQ(capacity.counts().refused_by_address, 1u);
}

TEST(Capacity, DoesNotCountClientsWithoutAddress) {
    Capacity capacity({.connections = 10, .per_address = 1});
    EXPECT_EQ(capacity.enter(""), Entry::Admitted);
    EXPECT_EQ(capacity.enter(""), Entry::Admitted);
    capacity.leave("");
    EXPECT_EQ(capacity.counts().open, 1u);
}

TEST(Capacity, IsPressedBeforeItIsFull) {
    Capacity capacity({.connections = 4, .per_address = 0});
    for (int i = 0; i < 3; ++i) capacity.enter("a");
    EXPECT_FALSE(capacity.is_pressed());
    capacity.enter("a");
    EXPECT_TRUE(capacity.is_pressed());
    capacity.leave("a");
    EXPECT_FALSE(capacity.is_pressed());
}

TEST(Capacity, CountsBytesUntilTheyAreLetGo) {
    Capacity capacity({.connections = 4, .per_address = 0, .bytes = 100});
    {
        Held held(&capacity);
        held.resize(50);
        EXPECT_FALSE(capacity.is_pressed());
        held.resize(51);
        EXPECT_TRUE(capacity.is_pressed());
        EXPECT_FALSE(capacity.is_out_of_memory());
        held.resize(101);
        EXPECT_TRUE(capacity.is_out_of_memory());
        held.resize(10);
        EXPECT_FALSE(capacity.is_pressed());
        held.resize(101);
    }
    EXPECT_FALSE(capacity.is_pressed());
}

TEST(Held, NeedsNoCapacity) {
    Held held(nullptr);
    held.resize(10);
}

}  // namespace
}  // namespace ccdt::server
