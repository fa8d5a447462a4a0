#include "server/http/capacity.h"

#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace ccdt::server {
namespace {

/// Time that whoever connects has to send something before it counts as idle: newcomers wait as long for its place.
constexpr std::chrono::milliseconds kLeastIdle{50};

/// Time that the head of a request has: several packets, of which one was lost.
constexpr std::chrono::milliseconds kLeastForHead{300};

/// Time that newcomers wait for idle connections to leave, and after which another of these is closed: only a busy
/// machine takes so long.
constexpr std::chrono::milliseconds kTimeToLeave{1'000};
constexpr std::chrono::milliseconds kTimeForAnother{100};

bool has_unread_bytes(int socket) {
    int bytes = 0;
    return ioctl(socket, FIONREAD, &bytes) == 0 && bytes > 0;
}

}  // namespace

Capacity::Counts Capacity::counts() const {
    const std::lock_guard lock(mutex_);
    Counts counts{0, taken_[static_cast<std::size_t>(Room::Streams)], refused_, refused_by_address_, refused_streams_};
    for (const auto& taken : taken_) counts.open += taken;
    return counts;
}

std::size_t Capacity::limit(Room room) const {
    switch (room) {
        case Room::Reserve:
            return limits_.reserve;
        case Room::Streams:
            return limits_.streams;
        case Room::Common:
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

/// Finds the idle connection that may be closed first, of a room or of any.
Capacity::IdleConnections::iterator Capacity::first_idle_locked(std::optional<Room> room) {
    return std::ranges::find_if(idle_, [room](const auto& entry) {
        const Idle& idle = entry.second;
        return (!room || idle.place->room_ == *room) && !has_unread_bytes(idle.socket);
    });
}

/// Closes an idle connection: its thread notices, and gives the place back.
void Capacity::close_locked(IdleConnections::iterator idle) {
    const auto& [place, socket, has_begun] = idle->second;
    shutdown(socket, has_begun ? SHUT_RD : SHUT_RDWR);
    place->closed_ = true;
    place->idle_.reset();
    idle_.erase(idle);
}

/// Has idle connections of a room leave until there is a place.
bool Capacity::free_place(Room room, std::unique_lock<std::mutex>& lock) {
    const auto end = Clock::now() + kTimeToLeave;
    while (!has_place_locked(room)) {
        const auto idle = first_idle_locked(room);
        const auto now = Clock::now();
        if (idle == idle_.end() || now >= end) return false;
        auto until = idle->first;
        if (now >= until) {
            close_locked(idle);
            until = now + kTimeForAnother;
        }
        left_.wait_until(lock, until, [&] { return has_place_locked(room); });
    }
    return true;
}

/// @returns  none if both rooms for newcomers are full, and nobody there is idle
std::optional<Room> Capacity::find_room(std::unique_lock<std::mutex>& lock) {
    for (const Room room : {Room::Common, Room::Reserve}) {
        if (free_place(room, lock)) return room;
    }
    return std::nullopt;
}

/// Counts one more of an address.
/// @returns  false if it has enough
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

Place::Place(Capacity& capacity, std::string address) : capacity_(capacity), address_(std::move(address)) {
    std::unique_lock lock(capacity_.mutex_);
    // Checked first: an address at its own limit must not close the connections of others.
    if (!capacity_.enter_locked(address_)) {
        entry_ = Entry::AddressFull;
        return;
    }
    const auto room = capacity_.find_room(lock);
    if (!room) {
        ++capacity_.refused_;
        capacity_.leave_locked(address_);
        return;
    }
    room_ = *room;
    entry_ = Entry::Admitted;
    ++capacity_.taken(room_);
}

Place::~Place() {
    if (entry_ != Entry::Admitted) return;
    end_idle();
    const std::lock_guard lock(capacity_.mutex_);
    --capacity_.taken(room_);
    capacity_.leave_locked(address_);
    capacity_.left_.notify_all();
}

void Place::begin_idle(int socket, std::optional<std::chrono::steady_clock::time_point> head_begun) {
    const std::lock_guard lock(capacity_.mutex_);
    if (closed_ || idle_) return;
    const auto until = head_begun ? *head_begun + kLeastForHead : Capacity::Clock::now() + kLeastIdle;
    idle_ = capacity_.idle_.insert({until, {this, socket, head_begun.has_value()}});
}

void Place::end_idle() {
    const std::lock_guard lock(capacity_.mutex_);
    if (idle_) capacity_.idle_.erase(*std::exchange(idle_, std::nullopt));
}

bool Place::is_closed() const {
    const std::lock_guard lock(capacity_.mutex_);
    return closed_;
}

bool Place::move_to(Room room) {
    if (room == Room::Reserve || room == room_) return true;
    const std::lock_guard lock(capacity_.mutex_);
    if (!capacity_.has_place_locked(room)) {
        ++(room == Room::Streams ? capacity_.refused_streams_ : capacity_.refused_);
        return false;
    }
    --capacity_.taken(std::exchange(room_, room));
    ++capacity_.taken(room);
    capacity_.left_.notify_all();
    return true;
}

bool Place::count_by(const std::string& address) {
    if (address == address_) return true;
    const std::lock_guard lock(capacity_.mutex_);
    if (!capacity_.enter_locked(address)) return false;
    capacity_.leave_locked(std::exchange(address_, address));
    return true;
}

void HeldBytes::resize(std::size_t bytes) {
    if (capacity_ == nullptr) return;
    if (bytes > bytes_) capacity_->hold(bytes - bytes_);
    if (bytes < bytes_) capacity_->release(bytes_ - bytes);
    bytes_ = bytes;
}

}  // namespace ccdt::server
