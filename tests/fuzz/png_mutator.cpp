// SPDX-License-Identifier: GPL-3.0-or-later
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kSignature = 8;
constexpr std::size_t kFrame = 12;  ///< bytes of a chunk's length, name and checksum together

std::uint32_t read_big_endian(const std::uint8_t* bytes) {
    return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 | bytes[3];
}

void write_big_endian(std::uint32_t value, std::uint8_t* bytes) {
    for (int shift = 24; shift >= 0; shift -= 8) *bytes++ = static_cast<std::uint8_t>(value >> shift);
}

/// Corrects the checksums of a PNG, because decoders reject chunks with wrong checksums.
void mend_checksums(std::uint8_t* data, std::size_t size) {
    if (size < kSignature || std::memcmp(data, "\x89PNG\r\n\x1a\n", kSignature) != 0) return;
    for (std::size_t chunk = kSignature; chunk + kFrame <= size;) {
        const std::uint32_t length = read_big_endian(data + chunk);
        if (length > size - chunk - kFrame) return;
        const auto sum = crc32(0, data + chunk + 4, length + 4);
        write_big_endian(static_cast<std::uint32_t>(sum), data + chunk + 8 + length);
        chunk += kFrame + length;
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Mutates an input; called by libFuzzer.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
    constexpr unsigned kLeftAlone = 8;  // one in eight inputs keeps its wrong checksums
    const std::size_t mutated = LLVMFuzzerMutate(data, size, max_size);
    if (seed % kLeftAlone != 0) ccdt::fuzz::mend_checksums(data, mutated);
    return mutated;
}
