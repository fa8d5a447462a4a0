// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/npy_header.h"

#include "api/input/npy_reader.h"

namespace ccdt::api {

std::string npy_header(std::string_view type, std::span<const std::size_t> shape) {
    constexpr std::size_t kAlignment = 64;  // the offset of the first element is a multiple of this
    std::string text = "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (";
    for (const std::size_t size : shape) text += std::to_string(size) + ", ";
    text.replace(text.size() - 2, 2, "), }");
    const std::size_t length = kNpyMagic.size() + 2 + text.size() + 1;
    text.append((kAlignment - length % kAlignment) % kAlignment, ' ') += '\n';

    std::string header(kNpyMagic);
    header += static_cast<char>(text.size() & 255);
    header += static_cast<char>(text.size() >> 8);
    return header += text;
}

}  // namespace ccdt::api
