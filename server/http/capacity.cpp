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

Place::Place(Capacity& capacity, std::string address) : capacity_(capacity), address_(std::move(address)) {
    const std::lock_guard lock(capacity_.mutex_);
    const bool common = capacity_.has_place_locked(Room::Common);
    if (!common && !capacity_.has_place_locked(Room::Reserve)) {
        ++capacity_.refused_;
        return;
    }
    if (const auto most = capacity_.limits_.per_address; most > 0 && !address_.empty()) {
        auto& count = capacity_.by_address_[address_];
        if (count >= most) {
            ++capacity_.refused_by_address_;
            entry_ = Entry::AddressFull;
            return;
        }
        ++count;
    }
    room_ = common ? Room::Common : Room::Reserve;
    entry_ = Entry::Admitted;
    ++capacity_.taken(room_);
}

Place::~Place() {
    if (entry_ != Entry::Admitted) return;
    const std::lock_guard lock(capacity_.mutex_);
    --capacity_.taken(room_);
    const auto found = capacity_.by_address_.find(address_);
    if (found != capacity_.by_address_.end() && --found->second == 0) capacity_.by_address_.erase(found);
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

void HeldBytes::resize(std::size_t bytes) {
    if (capacity_ == nullptr) return;
    if (bytes > bytes_) capacity_->hold(bytes - bytes_);
    if (bytes < bytes_) capacity_->release(bytes_ - bytes);
    bytes_ = bytes;
}

}  // namespace ccdt::server
