// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fstream>
#include <iterator>
#include <string>

namespace ccdt::bench {

/// Returns the content of a picture that all tests share.
inline std::string photograph(const std::string& name) {
    std::ifstream file(CCDT_TEST_DATA "/images/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace ccdt::bench
