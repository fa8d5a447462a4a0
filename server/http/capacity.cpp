#include "server/http/capacity.h"

#include <utility>

namespace ccdt::server {

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
    const std::lock_guard lock(capacity_.mutex_);
    const bool common = capacity_.has_place_locked(Room::Common);
    if (!common && !capacity_.has_place_locked(Room::Reserve)) {
        ++capacity_.refused_;
        return;
    }
    if (!capacity_.enter_locked(address_)) {
        entry_ = Entry::AddressFull;
        return;
    }
    room_ = common ? Room::Common : Room::Reserve;
    entry_ = Entry::Admitted;
    ++capacity_.taken(room_);
}

Place::~Place() {
    if (entry_ != Entry::Admitted) return;
    const std::lock_guard lock(capacity_.mutex_);
    --capacity_.taken(room_);
    capacity_.leave_locked(address_);
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
