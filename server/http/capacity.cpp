#include "server/http/capacity.h"

namespace ccdt::server {

Capacity::Entry Capacity::enter(const std::string& address) {
    const std::lock_guard lock(mutex_);
    if (open_ >= limits_.connections) {
        ++refused_;
        return Entry::Full;
    }
    if (limits_.per_address > 0 && !address.empty()) {
        auto& count = by_address_[address];
        if (count >= limits_.per_address) {
            ++refused_by_address_;
            return Entry::AddressFull;
        }
        ++count;
    }
    ++open_;
    return Entry::Admitted;
}

void Capacity::leave(const std::string& address) {
    const std::lock_guard lock(mutex_);
    --open_;
    const auto found = by_address_.find(address);
    if (found != by_address_.end() && --found->second == 0) by_address_.erase(found);
}

Capacity::Counts Capacity::counts() const {
    const std::lock_guard lock(mutex_);
    return {open_, refused_, refused_by_address_};
}

void Held::resize(std::size_t bytes) {
    if (capacity_ == nullptr) return;
    if (bytes > bytes_) capacity_->hold(bytes - bytes_);
    if (bytes < bytes_) capacity_->release(bytes_ - bytes);
    bytes_ = bytes;
}

}  // namespace ccdt::server
