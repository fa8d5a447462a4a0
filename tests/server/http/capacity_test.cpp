#include "server/http/capacity.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>
#include <utility>

namespace ccdt::server {
namespace {

using Clock = std::chrono::steady_clock;
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

/// A connection whose thread does nothing but wait for the end.
class IdleClient {
public:
    explicit IdleClient(Capacity& capacity, std::optional<Clock::time_point> head_begun = {})
        : place_(std::in_place, capacity, "") {
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets_.data()), 0);
        place_->begin_idle(sockets_[0], head_begun);
        thread_ = std::jthread([this] {
            char byte = 0;
            EXPECT_EQ(recv(sockets_[0], &byte, 1, MSG_PEEK | MSG_WAITALL), 0);
            closed_ = true;
            place_.reset();
        });
    }
    ~IdleClient() {
        shutdown(sockets_[1], SHUT_RDWR);
        thread_.join();
        for (const int socket : sockets_) ::close(socket);
    }
    IdleClient(const IdleClient&) = delete;
    IdleClient& operator=(const IdleClient&) = delete;

    bool is_closed() const { return closed_; }

    /// Whether the client can still be answered.
    bool can_be_told() const { return send(sockets_[0], "!", 1, MSG_NOSIGNAL) == 1; }

private:
    std::array<int, 2> sockets_{};
    std::atomic<bool> closed_ = false;
    std::optional<Place> place_;
    std::jthread thread_;
};

TEST(Capacity, ClosesWhoeverWasIdleLongestForANewcomer) {
    Capacity capacity({.connections = 3, .reserve = 1});
    const Place busy(capacity, "");
    IdleClient first(capacity);
    IdleClient second(capacity);
    const Place newcomer(capacity, "a");
    EXPECT_EQ(newcomer.entry(), Entry::Admitted);
    EXPECT_EQ(newcomer.room(), Room::Common);
    EXPECT_TRUE(first.is_closed());
    EXPECT_FALSE(second.is_closed());
    EXPECT_EQ(capacity.counts().refused, 0u);
}

TEST(Capacity, ClosesIdleConnectionsOfTheReserve) {
    Capacity capacity({.connections = 1, .reserve = 1});
    const Place busy(capacity, "");
    IdleClient idle(capacity);
    const Place newcomer(capacity, "a");
    EXPECT_EQ(newcomer.room(), Room::Reserve);
    EXPECT_TRUE(idle.is_closed());
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Full);
}

TEST(Capacity, ClosesIncompleteHeadsForANewcomer) {
    Capacity capacity({.connections = 2, .reserve = 0});
    IdleClient recent(capacity, Clock::now());
    IdleClient late(capacity, Clock::now() - std::chrono::seconds(1));
    const Place newcomer(capacity, "a");
    EXPECT_EQ(newcomer.entry(), Entry::Admitted);
    EXPECT_TRUE(late.is_closed());
    EXPECT_TRUE(late.can_be_told());
    EXPECT_FALSE(recent.is_closed());
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Admitted) << "the other one has less than a second left";
    EXPECT_TRUE(recent.is_closed());
    EXPECT_EQ(capacity.counts().refused, 0u);
}

TEST(Capacity, ClosesNobodyForAnAddressThatHasEnough) {
    Capacity capacity({.connections = 2, .reserve = 0, .per_address = 1});
    const Place busy(capacity, "a");
    IdleClient idle(capacity);
    EXPECT_EQ(Place(capacity, "a").entry(), Entry::AddressFull);
    EXPECT_FALSE(idle.is_closed());
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Admitted);
    EXPECT_TRUE(idle.is_closed());
}

TEST(Capacity, ClosesNobodyWhoHasSentARequest) {
    std::array<int, 2> sockets{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()), 0);
    Capacity capacity({.connections = 1, .reserve = 0});
    Place asking(capacity, "a");
    asking.begin_idle(sockets[0]);
    ASSERT_EQ(send(sockets[1], "G", 1, MSG_NOSIGNAL), 1);
    EXPECT_EQ(Place(capacity, "b").entry(), Entry::Full);
    EXPECT_FALSE(capacity.close_first_idle());
    asking.end_idle();
    for (const int socket : sockets) ::close(socket);
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
