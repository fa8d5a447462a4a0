// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

struct zip;

namespace ccdt::api {

/// A zip archive in memory, of which members are read one at a time.
class ZipArchive {
public:
    static constexpr std::size_t kMaxMembers = 1000;

    /// Reads the directory of an archive.
    /// @param bytes  must outlive the archive
    /// Errors: Unusable for what is no zip archive, or a truncated one; LimitExceeded for more than kMaxMembers.
    static Result<ZipArchive> open(std::string_view bytes);

    /// Paths of the members, in UTF-8, in the order of the directory.
    const std::vector<std::string>& names() const { return names_; }

    /// Inflates a member and checks its CRC.
    /// @param budget  bytes that it may have; reduced by those that it has
    /// Errors: Unusable for a member that is encrypted, damaged or not compressed by deflate; LimitExceeded, without a
    /// message, for one that is larger than the budget.
    Result<std::string> read(std::size_t member, std::size_t& budget) const;

private:
    explicit ZipArchive(struct zip* archive);

    std::shared_ptr<struct zip> archive_;
    std::vector<std::string> names_;
};

}  // namespace ccdt::api
