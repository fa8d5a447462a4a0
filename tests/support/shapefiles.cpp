// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/shapefiles.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace ccdt {
namespace {

template <class T>
void append_little(std::string& out, T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(value >> 8 * i & 0xFF);
}

void append_big(std::string& out, std::size_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift & 0xFF);
}

void append_double(std::string& out, double value) {
    append_little(out, std::bit_cast<std::uint64_t>(value));
}

std::string padded(std::string text, std::size_t size, char with) {
    text.resize(size, with);
    return text;
}

/// Returns the CRC-32 that zip archives use.
std::uint32_t crc_of(std::string_view bytes) {
    std::uint32_t crc = ~0U;
    for (const char c : bytes) {
        crc ^= static_cast<unsigned char>(c);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320U : 0);
    }
    return ~crc;
}

std::string record_of(const std::vector<Ring>& rings, int type) {
    std::string record;
    append_little(record, static_cast<std::uint32_t>(rings.empty() ? 0 : type));
    if (rings.empty()) return record;
    record.append(32, '\0');  // the bounding box, which the tested reader ignores
    append_little(record, static_cast<std::uint32_t>(rings.size()));
    std::size_t corners = 0;
    for (const Ring& ring : rings) corners += ring.size();
    append_little(record, static_cast<std::uint32_t>(corners));
    corners = 0;
    for (const Ring& ring : rings) {
        append_little(record, static_cast<std::uint32_t>(corners));
        corners += ring.size();
    }
    for (const Ring& ring : rings) {
        for (const Point& p : ring) {
            append_double(record, p.x);
            append_double(record, p.y);
        }
    }
    if (type == 15 || type == 25) record.append((type == 15 ? 2 : 1) * (16 + 8 * corners), '\0');
    return record;
}

}  // namespace

std::string shp_of(const std::vector<std::vector<Ring>>& shapes, int type) {
    std::string records;
    std::size_t number = 0;
    for (const auto& rings : shapes) {
        const std::string record = record_of(rings, type);
        append_big(records, ++number);
        append_big(records, record.size() / 2);
        records += record;
    }
    std::string file;
    append_big(file, 9994);
    file.append(20, '\0');
    append_big(file, (100 + records.size()) / 2);
    append_little(file, std::uint32_t{1000});
    append_little(file, static_cast<std::uint32_t>(type));
    return padded(std::move(file), 100, '\0') + records;
}

std::string dbf_of(const std::vector<TableField>& fields, const std::vector<std::vector<std::string>>& rows,
                   int language) {
    std::size_t length = 1;
    for (const TableField& field : fields) length += static_cast<std::size_t>(field.width);
    std::string file("\x03\x78\x01\x01", 4);
    append_little(file, static_cast<std::uint32_t>(rows.size()));
    append_little(file, static_cast<std::uint16_t>(33 + 32 * fields.size()));
    append_little(file, static_cast<std::uint16_t>(length));
    file = padded(std::move(file), 29, '\0');
    file += static_cast<char>(language);
    file.append(2, '\0');
    for (const TableField& field : fields) {
        std::string described = padded(field.name, 11, '\0');
        described += field.type;
        described.append(4, '\0');
        described += static_cast<char>(field.width);
        file += padded(std::move(described), 32, '\0');
    }
    file += '\r';
    for (const auto& row : rows) {
        file += ' ';
        for (std::size_t i = 0; i < fields.size(); ++i)
            file += padded(row[i], static_cast<std::size_t>(fields[i].width), ' ');
    }
    return file;
}

std::string zip_of(const std::vector<std::pair<std::string, std::string>>& files) {
    std::string archive;
    std::string directory;
    for (const auto& [name, bytes] : files) {
        std::string described;  // the part common to the local header and the directory entry
        append_little(described, std::uint16_t{20});
        described.append(8, '\0');  // flags, method, time and date
        append_little(described, crc_of(bytes));
        append_little(described, static_cast<std::uint32_t>(bytes.size()));
        append_little(described, static_cast<std::uint32_t>(bytes.size()));
        append_little(described, static_cast<std::uint16_t>(name.size()));
        append_little(described, std::uint16_t{0});
        const auto offset = static_cast<std::uint32_t>(archive.size());
        archive += "PK\x03\x04" + described + name + bytes;
        directory += std::string("PK\x01\x02\x14", 5) + '\0' + described + std::string(10, '\0');
        append_little(directory, offset);
        directory += name;
    }
    std::string end("PK\x05\x06\0\0\0\0", 8);
    append_little(end, static_cast<std::uint16_t>(files.size()));
    append_little(end, static_cast<std::uint16_t>(files.size()));
    append_little(end, static_cast<std::uint32_t>(directory.size()));
    append_little(end, static_cast<std::uint32_t>(archive.size()));
    return archive + directory + end + std::string(2, '\0');
}

}  // namespace ccdt
