// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/files/text_file.h"

#include <cstddef>
#include <fstream>

namespace ccdt::server {

Result<std::string> read_text_file(const std::string& path) {
    constexpr std::size_t kMax = 16 << 20;
    std::ifstream stream(path, std::ios::binary);
    std::string text(kMax + 1, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!stream.is_open() || stream.bad()) return failure(ErrorCode::Unusable, path + ": cannot be read");
    text.resize(static_cast<std::size_t>(stream.gcount()));
    if (text.size() > kMax) return failure(ErrorCode::Unusable, path + ": is larger than 16 MiB");
    return text;
}

}  // namespace ccdt::server
