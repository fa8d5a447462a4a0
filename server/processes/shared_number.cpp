// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/shared_number.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <new>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace ccdt::server {
namespace {

using Number = std::atomic<std::uint32_t>;
static_assert(Number::is_always_lock_free);

constexpr std::size_t kSize = sizeof(Number);

/// Seals of the file. They prevent truncation, which would crash readers, and writing other than by existing mappings.
constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;

const Number& number_in(const SharedPage& page) {
    return *std::launder(static_cast<const Number*>(page.get()));
}

}  // namespace

SharedPage::SharedPage(const UniqueFd& file, int protection) {
    void* const mapped = mmap(nullptr, kSize, protection, MAP_SHARED, file.get(), 0);
    if (mapped != MAP_FAILED) page_ = mapped;
}

SharedPage::~SharedPage() {
    if (page_ != nullptr) munmap(page_, kSize);
}

SharedPage::SharedPage(SharedPage&& other) noexcept : page_(std::exchange(other.page_, nullptr)) {}

SharedPage& SharedPage::operator=(SharedPage&& other) noexcept {
    std::swap(page_, other.page_);
    return *this;
}

Result<SharedNumber> SharedNumber::create(std::uint32_t value) {
    UniqueFd file(memfd_create("number", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (file && ftruncate(file.get(), kSize) == 0) {
        SharedPage page(file, PROT_READ | PROT_WRITE);
        if (page.get() != nullptr && fcntl(file.get(), F_ADD_SEALS, kSeals) == 0) {
            new (page.get()) Number(value);
            return SharedNumber(std::move(file), std::move(page));
        }
    }
    return failure(ErrorCode::Internal, std::string("cannot create shared memory: ") + std::strerror(errno));
}

SharedNumber::SharedNumber(UniqueFd file, SharedPage page) : file_(std::move(file)), page_(std::move(page)) {}

void SharedNumber::store(std::uint32_t value) {
    std::launder(static_cast<Number*>(page_.get()))->store(value, std::memory_order_relaxed);
}

std::uint32_t SharedNumber::load() const {
    return number_in(page_).load(std::memory_order_relaxed);
}

SharedNumberReader::SharedNumberReader(const UniqueFd& file) : page_(file, PROT_READ) {}

std::uint32_t SharedNumberReader::load(std::uint32_t otherwise) const {
    return page_.get() == nullptr ? otherwise : number_in(page_).load(std::memory_order_relaxed);
}

}  // namespace ccdt::server
