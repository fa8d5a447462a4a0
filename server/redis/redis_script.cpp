// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_script.h"

#include <openssl/sha.h>

namespace ccdt::server {

RedisScript::RedisScript(std::string_view flags, std::initializer_list<std::string_view> parts)
    : source_("#!lua flags=" + std::string(flags) + '\n') {
    for (const std::string_view part : parts) source_.append(part) += '\n';
    unsigned char digest[SHA_DIGEST_LENGTH];
    SHA1(reinterpret_cast<const unsigned char*>(source_.data()), source_.size(), digest);
    for (const unsigned byte : digest) {
        digest_ += "0123456789abcdef"[byte / 16];
        digest_ += "0123456789abcdef"[byte % 16];
    }
}

}  // namespace ccdt::server
