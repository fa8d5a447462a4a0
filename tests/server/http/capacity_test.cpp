// SPDX-License-Identifier: GPL-3.0-or-later
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
using Entry = ConnectionSlot::Entry;

TEST(Capacity, LimitsTheTotalNumberOfConnections) {
    Capacity capacity({.connections = 2, .reserve = 0, .per_address = 0});
    std::optional<ConnectionSlot> first(std::in_place, capacity, "a");
    const ConnectionSlot second(capacity, "a");
    EXPECT_EQ(first->entry(), Entry::Admitted);
    EXPECT_EQ(second.entry(), Entry::Admitted);
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Full);
    first.reset();
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().open, 1u);
    EXPECT_EQ(capacity.counts().refused, 1u);
}

TEST(Capacity, LimitsConnectionsPerAddress) {
    Capacity capacity({.connections = 10, .per_address = 1});
    std::optional<ConnectionSlot> first(std::in_place, capacity, "a");
    EXPECT_EQ(first->entry(), Entry::Admitted);
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::AddressFull);
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Admitted);
    EXPECT_TRUE(first->move_to(ConnectionClass::Streams));
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::AddressFull) << "connections of all classes count";
    first.reset();
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().refused_by_address, 2u);
}

TEST(Capacity, ReassignsAConnectionToAnAddressBelowItsLimit) {
    Capacity capacity({.connections = 10, .per_address = 1});
    ConnectionSlot proxied(capacity, "");
    std::optional<ConnectionSlot> other(std::in_place, capacity, "b");
    EXPECT_TRUE(proxied.count_by("a"));
    EXPECT_TRUE(proxied.count_by("a")) << "it counts by this address already";
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::AddressFull);
    EXPECT_FALSE(proxied.count_by("b"));
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::AddressFull) << "it must count by its previous address";
    other.reset();
    EXPECT_TRUE(proxied.count_by("b"));
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::Admitted);
    EXPECT_TRUE(proxied.count_by(""));
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().refused_by_address, 3u);
    EXPECT_EQ(capacity.counts().open, 1u);
}

TEST(Capacity, DoesNotCountClientsWithoutAddress) {
    Capacity capacity({.connections = 10, .per_address = 1});
    const ConnectionSlot first(capacity, "");
    EXPECT_EQ(ConnectionSlot(capacity, "").entry(), Entry::Admitted);
    EXPECT_EQ(capacity.counts().open, 1u);
}

TEST(Capacity, UsesTheReserveAfterTheCommonSlots) {
    Capacity capacity({.connections = 1, .reserve = 1, .streams = 0});
    std::optional<ConnectionSlot> common(std::in_place, capacity, "a");
    ConnectionSlot other(capacity, "b");
    EXPECT_EQ(common->connection_class(), ConnectionClass::Common);
    EXPECT_EQ(other.connection_class(), ConnectionClass::Reserve);
    EXPECT_EQ(ConnectionSlot(capacity, "c").entry(), Entry::Full);
    EXPECT_TRUE(other.move_to(ConnectionClass::Reserve));
    EXPECT_FALSE(other.move_to(ConnectionClass::Common));
    EXPECT_EQ(other.connection_class(), ConnectionClass::Reserve);
    EXPECT_EQ(capacity.counts().refused, 2u);
    common.reset();
    EXPECT_TRUE(other.move_to(ConnectionClass::Common));
    EXPECT_EQ(ConnectionSlot(capacity, "c").connection_class(), ConnectionClass::Reserve);
}

/// An idle connection, whose thread waits until the connection is closed.
class IdleClient {
public:
    explicit IdleClient(Capacity& capacity, std::optional<Clock::time_point> head_begun = {})
        : slot_(std::in_place, capacity, "") {
        EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets_.data()), 0);
        slot_->begin_idle(sockets_[0], head_begun);
        thread_ = std::jthread([this] {
            char byte = 0;
            EXPECT_EQ(recv(sockets_[0], &byte, 1, MSG_PEEK | MSG_WAITALL), 0);
            closed_ = true;
            slot_.reset();
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

    /// Whether an answer can still be sent to the client.
    bool can_be_answered() const { return send(sockets_[0], "!", 1, MSG_NOSIGNAL) == 1; }

private:
    std::array<int, 2> sockets_{};
    std::atomic<bool> closed_ = false;
    std::optional<ConnectionSlot> slot_;
    std::jthread thread_;
};

TEST(Capacity, ClosesTheLongestIdleConnectionForANewOne) {
    Capacity capacity({.connections = 3, .reserve = 1});
    const ConnectionSlot busy(capacity, "");
    IdleClient first(capacity);
    IdleClient second(capacity);
    const ConnectionSlot newcomer(capacity, "a");
    EXPECT_EQ(newcomer.entry(), Entry::Admitted);
    EXPECT_EQ(newcomer.connection_class(), ConnectionClass::Common);
    EXPECT_TRUE(first.is_closed());
    EXPECT_FALSE(second.is_closed());
    EXPECT_EQ(capacity.counts().refused, 0u);
}

TEST(Capacity, ClosesIdleConnectionsOfTheReserve) {
    Capacity capacity({.connections = 1, .reserve = 1});
    const ConnectionSlot busy(capacity, "");
    IdleClient idle(capacity);
    const ConnectionSlot newcomer(capacity, "a");
    EXPECT_EQ(newcomer.connection_class(), ConnectionClass::Reserve);
    EXPECT_TRUE(idle.is_closed());
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Full);
}

TEST(Capacity, ClosesIncompleteHeadsForANewcomer) {
    Capacity capacity({.connections = 2, .reserve = 0});
    IdleClient recent(capacity, Clock::now());
    IdleClient late(capacity, Clock::now() - std::chrono::seconds(1));
    const ConnectionSlot newcomer(capacity, "a");
    EXPECT_EQ(newcomer.entry(), Entry::Admitted);
    EXPECT_TRUE(late.is_closed());
    EXPECT_TRUE(late.can_be_answered());
    EXPECT_FALSE(recent.is_closed());
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Admitted)
        << "the idle connection must be closed within a second";
    EXPECT_TRUE(recent.is_closed());
    EXPECT_EQ(capacity.counts().refused, 0u);
}

TEST(Capacity, ClosesNoConnectionForAnAddressAtItsLimit) {
    Capacity capacity({.connections = 2, .reserve = 0, .per_address = 1});
    const ConnectionSlot busy(capacity, "a");
    IdleClient idle(capacity);
    EXPECT_EQ(ConnectionSlot(capacity, "a").entry(), Entry::AddressFull);
    EXPECT_FALSE(idle.is_closed());
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Admitted);
    EXPECT_TRUE(idle.is_closed());
}

TEST(Capacity, ClosesNoConnectionWithAPendingRequest) {
    std::array<int, 2> sockets{};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()), 0);
    Capacity capacity({.connections = 1, .reserve = 0});
    ConnectionSlot asking(capacity, "a");
    asking.begin_idle(sockets[0]);
    ASSERT_EQ(send(sockets[1], "G", 1, MSG_NOSIGNAL), 1);
    EXPECT_EQ(ConnectionSlot(capacity, "b").entry(), Entry::Full);
    EXPECT_FALSE(capacity.close_first_idle());
    asking.end_idle();
    for (const int socket : sockets) ::close(socket);
}

TEST(Capacity, CountsStreamsSeparately) {
    Capacity capacity({.connections = 1, .reserve = 0, .streams = 1});
    ConnectionSlot stream(capacity, "a");
    EXPECT_TRUE(stream.move_to(ConnectionClass::Streams));
    EXPECT_TRUE(stream.move_to(ConnectionClass::Streams));
    EXPECT_EQ(stream.connection_class(), ConnectionClass::Streams);
    ConnectionSlot other(capacity, "b");
    EXPECT_EQ(other.entry(), Entry::Admitted);
    EXPECT_FALSE(other.move_to(ConnectionClass::Streams));
    EXPECT_FALSE(stream.move_to(ConnectionClass::Common));
    EXPECT_TRUE(stream.move_to(ConnectionClass::Reserve)) << "any slot will do";
    EXPECT_EQ(stream.connection_class(), ConnectionClass::Streams);
    EXPECT_EQ(capacity.counts().open, 2u);
    EXPECT_EQ(capacity.counts().streams, 1u);
    EXPECT_EQ(capacity.counts().refused_streams, 1u);
}

TEST(Capacity, IsUnderPressureBeforeItIsFull) {
    Capacity capacity({.connections = 4, .per_address = 0});
    const ConnectionSlot first(capacity, "a");
    const ConnectionSlot second(capacity, "a");
    const ConnectionSlot third(capacity, "a");
    EXPECT_FALSE(capacity.is_pressed());
    std::optional<ConnectionSlot> fourth(std::in_place, capacity, "a");
    EXPECT_TRUE(capacity.is_pressed());
    EXPECT_TRUE(fourth->move_to(ConnectionClass::Streams));
    EXPECT_FALSE(capacity.is_pressed()) << "streams press nobody";
    EXPECT_TRUE(fourth->move_to(ConnectionClass::Common));
    EXPECT_TRUE(capacity.is_pressed());
    fourth.reset();
    EXPECT_FALSE(capacity.is_pressed());
}

TEST(Capacity, CountsBytesUntilTheyAreReleased) {
    Capacity capacity({.connections = 4, .per_address = 0, .bytes = 100});
    {
        CountedBytes held(&capacity);
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

TEST(CountedBytes, WorksWithoutACapacity) {
    CountedBytes held(nullptr);
    held.resize(10);
}

}  // namespace
}  // namespace ccdt::server
