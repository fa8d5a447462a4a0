// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/archive.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace ccdt::api {
namespace {

constexpr std::uint32_t kFileHead = 0x04034b50, kEntryHead = 0x02014b50, kEnd = 0x06054b50;
constexpr std::size_t kFileHeadBytes = 30, kEntryHeadBytes = 46;
constexpr std::size_t kSizeAt = 18, kNameSizeAt = 26;  ///< offsets in the head of a file

/// Computes the checksum of ISO/IEC 3309.
std::uint32_t crc32(std::string_view bytes) {
    static constexpr auto kTable = [] {
        constexpr std::uint32_t kPolynomial = 0xedb88320;
        std::array<std::uint32_t, 256> table{};
        for (std::uint32_t i = 0; i < table.size(); ++i) {
            table[i] = i;
            for (int bit = 0; bit < 8; ++bit) table[i] = table[i] >> 1 ^ ((table[i] & 1) != 0 ? kPolynomial : 0);
        }
        return table;
    }();
    std::uint32_t sum = ~std::uint32_t{0};
    for (const char c : bytes) sum = sum >> 8 ^ kTable[(sum ^ static_cast<unsigned char>(c)) & 0xff];
    return ~sum;
}

/// Appends numbers with the lowest byte first.
void append(std::string& out, std::size_t bytes, std::initializer_list<std::uint64_t> numbers) {
    for (std::uint64_t number : numbers) {
        for (std::size_t i = 0; i < bytes; ++i, number >>= 8) out += static_cast<char>(number & 0xff);
    }
}

std::size_t number_at(std::string_view text, std::size_t at, std::size_t bytes) {
    std::size_t number = 0;
    for (std::size_t i = bytes; i-- > 0;) number = number << 8 | static_cast<unsigned char>(text[at + i]);
    return number;
}

/// Appends the fields that the head of a file shares with its entry in the directory. The date is 1 January 1980.
void append_fields(std::string& out, const ArchivedFile& file, std::uint32_t sum, std::size_t size) {
    append(out, 2, {20, 0, 0, 0, 0x21});  // version, flags, no compression, time, date
    append(out, 4, {sum, size, size});
    append(out, 2, {file.name.size(), 0});
}

}  // namespace

Result<void> write_archive(std::vector<ArchivedFile> files, Body& body) {
    std::size_t total = 0;
    for (const ArchivedFile& file : files)
        total += kFileHeadBytes + kEntryHeadBytes + 2 * file.name.size() + file.bytes.size();
    if (files.size() > std::numeric_limits<std::uint16_t>::max() || total > std::numeric_limits<std::uint32_t>::max())
        return failure(ErrorCode::LimitExceeded, "an archive has at most 65535 files and 4 GiB");
    std::string directory;
    std::size_t at = 0;
    for (ArchivedFile& file : files) {
        const std::uint32_t sum = crc32(file.bytes);
        append(directory, 4, {kEntryHead});
        append(directory, 2, {20});
        append_fields(directory, file, sum, file.bytes.size());
        append(directory, 2, {0, 0, 0});  // comment, disk, attributes
        append(directory, 4, {0, at});
        directory += file.name;
        append(body.text(), 4, {kFileHead});
        append_fields(body.text(), file, sum, file.bytes.size());
        body.text() += file.name;
        body.text() += file.bytes;
        at += kFileHeadBytes + file.name.size() + file.bytes.size();
        file.bytes = {};
        body.flush();
    }
    body.text() += directory;
    append(body.text(), 4, {kEnd});
    append(body.text(), 2, {0, 0, files.size(), files.size()});
    append(body.text(), 4, {directory.size(), at});
    append(body.text(), 2, {0});
    return {};
}

std::vector<ArchivedFile> read_archive(std::string_view archive) {
    std::vector<ArchivedFile> files;
    while (archive.size() >= kFileHeadBytes && number_at(archive, 0, 4) == kFileHead) {
        const std::size_t size = number_at(archive, kSizeAt, 4), name = number_at(archive, kNameSizeAt, 2);
        files.push_back({std::string(archive.substr(kFileHeadBytes, name)),
                         std::string(archive.substr(kFileHeadBytes + name, size))});
        archive.remove_prefix(kFileHeadBytes + name + size);
    }
    return files;
}

}  // namespace ccdt::api
