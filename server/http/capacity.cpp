// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/capacity.h"

#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace ccdt::server {
namespace {

/// Minimum idle time before a connection is closed in favour of a new one. During this time, a client that has just
/// connected can send its first request.
constexpr std::chrono::milliseconds kMinIdle{50};

/// Minimum time that a request head may take before its connection is closed in favour of a new one. Suffices for
/// several packets and the retransmission of one of them.
constexpr std::chrono::milliseconds kMinForHead{300};

/// Maximum time that a new connection waits for a slot. Longer than a closed connection needs to release its slot,
/// unless the machine is busy.
constexpr std::chrono::milliseconds kTimeToLeave{1'000};

/// Interval at which idle connections are closed while a new connection waits for a slot.
constexpr std::chrono::milliseconds kTimeForAnother{100};

bool has_unread_bytes(int socket) {
    int bytes = 0;
    return ioctl(socket, FIONREAD, &bytes) == 0 && bytes > 0;
}

}  // namespace

Capacity::Counts Capacity::counts() const {
    const std::lock_guard lock(mutex_);
    Counts counts{0, taken_[static_cast<std::size_t>(ConnectionClass::Streams)], refused_, refused_by_address_,
                  refused_streams_};
    for (const auto& taken : taken_) counts.open += taken;
    return counts;
}

std::size_t Capacity::limit(ConnectionClass connection_class) const {
    switch (connection_class) {
        case ConnectionClass::Reserve:
            return limits_.reserve;
        case ConnectionClass::Streams:
            return limits_.streams;
        case ConnectionClass::Common:
            break;
    }
    return limits_.connections;
}

bool Capacity::close_first_idle() {
    const std::lock_guard lock(mutex_);
    const auto idle = first_idle_locked(std::nullopt);
    if (idle == idle_.end()) return false;
    close_locked(idle);
    return true;
}

/// Finds the first idle connection without unread bytes.
/// @param connection_class  none: any class
Capacity::IdleConnections::iterator Capacity::first_idle_locked(std::optional<ConnectionClass> connection_class) {
    return std::ranges::find_if(idle_, [connection_class](const auto& entry) {
        const Idle& idle = entry.second;
        return (!connection_class || idle.slot->class_ == *connection_class) && !has_unread_bytes(idle.socket);
    });
}

bool Capacity::has_idle_locked(ConnectionClass connection_class) const {
    return std::ranges::any_of(
        idle_, [connection_class](const auto& entry) { return entry.second.slot->class_ == connection_class; });
}

/// Shuts down the socket of an idle connection. The connection's thread notices this and releases the slot.
void Capacity::close_locked(IdleConnections::iterator idle) {
    const auto& [slot, socket, has_begun] = idle->second;
    shutdown(socket, has_begun ? SHUT_RD : SHUT_RDWR);
    slot->closed_ = true;
    slot->idle_.reset();
    idle_.erase(idle);
}

/// Waits for a free slot of a class, and meanwhile closes idle connections of that class.
/// @returns  false if no slot became free
bool Capacity::free_slot(ConnectionClass connection_class, std::unique_lock<std::mutex>& lock) {
    const auto end = Clock::now() + kTimeToLeave;
    while (!has_slot_locked(connection_class)) {
        const auto idle = first_idle_locked(connection_class);
        const auto now = Clock::now();
        if (now >= end || !has_idle_locked(connection_class)) return false;
        // Connections with unread bytes may be idle again as soon as their threads have read these bytes.
        auto until = idle == idle_.end() ? now + kTimeForAnother : idle->first;
        if (now >= until) {
            close_locked(idle);
            until = now + kTimeForAnother;
        }
        left_.wait_until(lock, until, [&] { return has_slot_locked(connection_class); });
    }
    return true;
}

/// Finds a class with a free slot for a new connection.
/// @returns  none if the common class and the reserve are full and no slot became free
std::optional<ConnectionClass> Capacity::find_class(std::unique_lock<std::mutex>& lock) {
    for (const ConnectionClass connection_class : {ConnectionClass::Common, ConnectionClass::Reserve}) {
        if (free_slot(connection_class, lock)) return connection_class;
    }
    return std::nullopt;
}

/// Counts one more connection from an address.
/// @returns  false if the address is at its limit
bool Capacity::enter_locked(const std::string& address) {
    if (limits_.per_address == 0 || address.empty()) return true;
    auto& count = by_address_[address];
    if (count >= limits_.per_address) {
        ++refused_by_address_;
        return false;
    }
    ++count;
    return true;
}

void Capacity::leave_locked(const std::string& address) {
    const auto found = by_address_.find(address);
    if (found != by_address_.end() && --found->second == 0) by_address_.erase(found);
}

ConnectionSlot::ConnectionSlot(Capacity& capacity, std::string address)
    : capacity_(capacity), address_(std::move(address)) {
    std::unique_lock lock(capacity_.mutex_);
    // Checked first, because an address at its own limit must not close connections of other addresses.
    if (!capacity_.enter_locked(address_)) {
        entry_ = Entry::AddressFull;
        return;
    }
    const auto connection_class = capacity_.find_class(lock);
    if (!connection_class) {
        ++capacity_.refused_;
        capacity_.leave_locked(address_);
        return;
    }
    class_ = *connection_class;
    entry_ = Entry::Admitted;
    ++capacity_.taken(class_);
}

ConnectionSlot::~ConnectionSlot() {
    if (entry_ != Entry::Admitted) return;
    end_idle();
    const std::lock_guard lock(capacity_.mutex_);
    --capacity_.taken(class_);
    capacity_.leave_locked(address_);
    capacity_.left_.notify_all();
}

void ConnectionSlot::begin_idle(int socket, std::optional<std::chrono::steady_clock::time_point> head_begun) {
    const std::lock_guard lock(capacity_.mutex_);
    if (closed_ || idle_) return;
    const auto until = head_begun ? *head_begun + kMinForHead : Capacity::Clock::now() + kMinIdle;
    idle_ = capacity_.idle_.insert({until, {this, socket, head_begun.has_value()}});
}

void ConnectionSlot::end_idle() {
    const std::lock_guard lock(capacity_.mutex_);
    if (idle_) capacity_.idle_.erase(*std::exchange(idle_, std::nullopt));
}

bool ConnectionSlot::is_closed() const {
    const std::lock_guard lock(capacity_.mutex_);
    return closed_;
}

bool ConnectionSlot::move_to(ConnectionClass connection_class) {
    if (connection_class == ConnectionClass::Reserve || connection_class == class_) return true;
    const std::lock_guard lock(capacity_.mutex_);
    if (!capacity_.has_slot_locked(connection_class)) {
        ++(connection_class == ConnectionClass::Streams ? capacity_.refused_streams_ : capacity_.refused_);
        return false;
    }
    --capacity_.taken(std::exchange(class_, connection_class));
    ++capacity_.taken(connection_class);
    capacity_.left_.notify_all();
    return true;
}

bool ConnectionSlot::count_by(const std::string& address) {
    if (address == address_) return true;
    const std::lock_guard lock(capacity_.mutex_);
    if (!capacity_.enter_locked(address)) return false;
    capacity_.leave_locked(std::exchange(address_, address));
    return true;
}

void CountedBytes::resize(std::size_t bytes) {
    if (capacity_ == nullptr) return;
    if (bytes > bytes_) capacity_->add_bytes(bytes - bytes_);
    if (bytes < bytes_) capacity_->remove_bytes(bytes_ - bytes);
    bytes_ = bytes;
}

}  // namespace ccdt::server
