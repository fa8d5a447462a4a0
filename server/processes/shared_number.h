// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A page of memory that several processes share.
class SharedPage {
public:
    SharedPage() = default;

    /// Maps the first page of a file. After a failure, `get` returns null.
    SharedPage(const UniqueFd& file, int protection);
    ~SharedPage();
    SharedPage(SharedPage&& other) noexcept;
    SharedPage& operator=(SharedPage&& other) noexcept;

    void* get() const { return page_; }

private:
    void* page_ = nullptr;
};

/// A number that the threads of one process write and other processes read, without system calls.
class SharedNumber {
public:
    /// Creates the number with a value. Error: Internal.
    static Result<SharedNumber> create(std::uint32_t value);

    void store(std::uint32_t value);
    std::uint32_t load() const;

    /// Returns a file through which another process can map the number for reading only.
    const UniqueFd& file() const { return file_; }

private:
    SharedNumber(UniqueFd file, SharedPage page);

    UniqueFd file_;
    SharedPage page_;
};

/// Reads a SharedNumber of another process.
class SharedNumberReader {
public:
    /// @param file  from SharedNumber::file; may be closed afterwards
    explicit SharedNumberReader(const UniqueFd& file);

    /// Returns the number, or `otherwise` if the memory could not be mapped.
    std::uint32_t load(std::uint32_t otherwise) const;

private:
    SharedPage page_;
};

}  // namespace ccdt::server
