// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

struct zip;

namespace ccdt::api {

/// A zip archive in memory, whose members are read one at a time.
class ZipArchive {
public:
    static constexpr std::size_t kMaxMembers = 1000;

    /// Reads the directory of an archive.
    /// @param bytes  must outlive the archive
    /// Errors: Unusable if the bytes are not a complete zip archive; LimitExceeded for more than kMaxMembers members.
    static Result<ZipArchive> open(std::string_view bytes);

    /// Returns the paths of the members, in UTF-8, in the order of the directory.
    const std::vector<std::string>& names() const { return names_; }

    /// Inflates a member and checks its CRC.
    /// @param member  index into names()
    /// @param budget  maximum size of the member in bytes; reduced by the size of the member
    /// Errors: Unusable for a member that is encrypted, damaged, or neither stored nor compressed by deflate;
    /// LimitExceeded, with an empty message, for a member larger than the budget.
    Result<std::string> read(std::size_t member, std::size_t& budget) const;

private:
    explicit ZipArchive(struct zip* archive);

    std::shared_ptr<struct zip> archive_;
    std::vector<std::string> names_;
};

}  // namespace ccdt::api
