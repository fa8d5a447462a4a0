// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "core/result.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// A page of memory that processes share.
class SharedPage {
public:
    SharedPage() = default;

    /// Maps the first page of a file; `get` returns null if that failed.
    SharedPage(const UniqueFd& file, int protection);
    ~SharedPage();
    SharedPage(SharedPage&& other) noexcept;
    SharedPage& operator=(SharedPage&& other) noexcept;

    void* get() const { return page_; }

private:
    void* page_ = nullptr;
};

/// A number that any thread of one process writes and other processes read. Writing and reading need no system call.
class SharedNumber {
public:
    /// Errors: Internal.
    static Result<SharedNumber> create(std::uint32_t value);

    void store(std::uint32_t value);
    std::uint32_t load() const;

    /// A file through which another process can read the number, but not write it.
    const UniqueFd& file() const { return file_; }

private:
    SharedNumber(UniqueFd file, SharedPage page);

    UniqueFd file_;
    SharedPage page_;
};

/// Reads a SharedNumber of another process.
class SharedNumberReader {
public:
    /// @param file  see SharedNumber::file; may be closed afterwards
    explicit SharedNumberReader(const UniqueFd& file);

    /// @returns  `otherwise` if the memory could not be mapped
    std::uint32_t load(std::uint32_t otherwise) const;

private:
    SharedPage page_;
};

}  // namespace ccdt::server
