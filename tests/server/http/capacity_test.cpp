#include "server/http/capacity.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

namespace ccdt::server {
namespace {

using Entry = Place::Entry;

TEST(Capacity, LimitsConnectionsInAll) {
    Capacity capacity({.connections = 2, .reserve = 0, .per_address = 0});
    std::optional<Place> first(std::in_place, capacity, "a");
    const Place second(capacity, "a");
    EXPECT_EQ(first->entry(), Entry::Admitted);
    EXPECT_EQ(second.entry(), Entry::Admitted);
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Full);
    first.reset();
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().open, 1u);
    EXPECT_EQ(capacity.counts().refused, 1u);
}

TEST(Capacity, LimitsConnectionsOfAnAddress) {
    Capacity capacity({.connections = 10, .per_address = 1});
    std::optional<Place> first(std::in_place, capacity, "a");
    EXPECT_EQ(first->entry(), Entry::Admitted);
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::AddressFull);
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Admitted);
    EXPECT_TRUE(first->move_to(Room::Streams));
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::AddressFull) << "wherever its place is";
    first.reset();
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().refused_by_address, 2u);
}

TEST(Capacity, CountsAPlaceByAnotherAddressIfThatHasNotEnough) {
    Capacity capacity({.connections = 10, .per_address = 1});
    Place proxied(capacity, "");
    std::optional<Place> other(std::in_place, capacity, "b");
    EXPECT_TRUE(proxied.count_by("a"));
    EXPECT_TRUE(proxied.count_by("a")) << "it is its own";
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::AddressFull);
    EXPECT_FALSE(proxied.count_by("b"));
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::AddressFull) << "it counts as before";
    other.reset();
    EXPECT_TRUE(proxied.count_by("b"));
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::Admitted);
    EXPECT_TRUE(proxied.count_by(""));
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().refused_by_address, 3u);
    EXPECT_EQ(capacity.counts().open, 1u);
}

TEST(Capacity, DoesNotCountClientsWithoutAddress) {
    Capacity capacity({.connections = 10, .per_address = 1});
    const Place first(capacity, "");
    EXPECT_EQ(Place(capacity, "").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().open, 1u);
}

TEST(Capacity, HasAReserveOnceTheCommonPlacesAreTaken) {
    Capacity capacity({.connections = 1, .reserve = 1, .streams = 0});
    std::optional<Place> common(std::in_place, capacity, "a");
    Place other(capacity, "b");
    EXPECT_EQ(common->room(), Room::Common);
    EXPECT_EQ(other.room(), Room::Reserve);
    EXPECT_EQ(Place(capacity, "c").entry(), Entry::Full);
    EXPECT_TRUE(other.move_to(Room::Reserve));
    EXPECT_FALSE(other.move_to(Room::Common));
    EXPECT_EQ(other.room(), Room::Reserve);
    EXPECT_EQ(capacity.counts().refused, 2u);
    common.reset();
    EXPECT_TRUE(other.move_to(Room::Common));
    EXPECT_EQ(Place(capacity, "c").room(), Room::Reserve);
}

TEST(Capacity, KeepsStreamsApart) {
    Capacity capacity({.connections = 1, .reserve = 0, .streams = 1});
    Place stream(capacity, "a");
    EXPECT_TRUE(stream.move_to(Room::Streams));
    EXPECT_TRUE(stream.move_to(Room::Streams));
    EXPECT_EQ(stream.room(), Room::Streams);
    Place other(capacity, "b");
    EXPECT_EQ(other.entry(), Entry::Admitted);
    EXPECT_FALSE(other.move_to(Room::Streams));
    EXPECT_FALSE(stream.move_to(Room::Common));
    EXPECT_TRUE(stream.move_to(Room::Reserve)) << "any place will do";
    EXPECT_EQ(stream.room(), Room::Streams);
    EXPECT_EQ(capacity.counts().open, 2u);
    EXPECT_EQ(capacity.counts().streams, 1u);
    EXPECT_EQ(capacity.counts().refused_streams, 1u);
}

TEST(Capacity, IsPressedBeforeItIsFull) {
    Capacity capacity({.connections = 4, .per_address = 0});
    const Place first(capacity, "a");
    const Place second(capacity, "a");
    const Place third(capacity, "a");
    EXPECT_FALSE(capacity.is_pressed());
    std::optional<Place> fourth(std::in_place, capacity, "a");
    EXPECT_TRUE(capacity.is_pressed());
    EXPECT_TRUE(fourth->move_to(Room::Streams));
    EXPECT_FALSE(capacity.is_pressed()) << "streams press nobody";
    EXPECT_TRUE(fourth->move_to(Room::Common));
    EXPECT_TRUE(capacity.is_pressed());
    fourth.reset();
    EXPECT_FALSE(capacity.is_pressed());
}

TEST(Capacity, CountsBytesUntilTheyAreLetGo) {
    Capacity capacity({.connections = 4, .per_address = 0, .bytes = 100});
    {
        HeldBytes held(&capacity);
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

TEST(HeldBytes, NeedsNoCapacity) {
    HeldBytes held(nullptr);
    held.resize(10);
}

}  // namespace
}  // namespace ccdt::server
