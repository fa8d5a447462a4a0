// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/npy_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace ccdt::api {
namespace {

using namespace std::string_literals;

std::string npy(const std::string& type, const std::string& shape, const std::string& data, bool is_fortran = false) {
    const std::string header = "{'descr': '" + type + "', 'fortran_order': " + (is_fortran ? "True" : "False") +
                               ", 'shape': (" + shape + "), }\n";
    return std::string(kNpyMagic) + static_cast<char>(header.size()) + '\0' + header + data;
}

std::vector<double> values(const std::string& file) {
    const auto array = read_npy(file);
    EXPECT_TRUE(array) << array.error().message;
    EXPECT_TRUE(array && array->has_numbers());
    std::vector<double> values;
    std::size_t count = 1;
    for (const std::size_t side : array->shape) count *= side;
    for (std::size_t i = 0; i < count; ++i) values.push_back(array->value(i));
    return values;
}

TEST(NpyReader, ReadsFloatsOfTwoBytes) {
    // 1, -2, the largest, the smallest normal and subnormal numbers, 1/3, zeros
    EXPECT_EQ(values(npy("<f2", "8,", "\x00\x3c\x00\xc0\xff\x7b\x00\x04\x01\x00\x55\x35\x00\x00\x00\x80"s)),
              (std::vector<double>{1, -2, 65504, 0x1p-14, 0x1p-24, 0.333251953125, 0, 0}));
    EXPECT_EQ(values(npy(">f2", "2,", "\x3c\x00\x35\x55"s)), (std::vector<double>{1, 0.333251953125}));
    EXPECT_EQ(values(npy("<f2", "2,", "\x00\x7c\x00\xfc"s)), (std::vector<double>{INFINITY, -INFINITY}));
    EXPECT_TRUE(std::isnan(values(npy("<f2", "1,", "\x01\x7c"s)).front()));
}

TEST(NpyReader, ReadsBothByteOrders) {
    EXPECT_EQ(values(npy("<i2", "2,", "\x01\x02\xff\xff"s)), (std::vector<double>{513, -1}));
    EXPECT_EQ(values(npy(">i2", "2,", "\x01\x02\xff\xff"s)), (std::vector<double>{258, -1}));
    EXPECT_EQ(values(npy(">f8", "1,", "\x3f\xf8\0\0\0\0\0\0"s)), std::vector<double>{1.5});
    EXPECT_EQ(values(npy("|b1", "2,", "\x00\x01"s)), (std::vector<double>{0, 1}));
}

TEST(NpyReader, ReadsAllVersions) {
    std::string file = npy("|u1", "2,", "\x07\x09"s);
    for (const char version : {'\2', '\3'}) {
        std::string later = file;
        later[6] = version;
        later.insert(10, 2, '\0');
        EXPECT_EQ(values(later), (std::vector<double>{7, 9}));
        for (std::size_t size = 0; size < 12; ++size) EXPECT_FALSE(read_npy(later.substr(0, size))) << size;
    }
    file[6] = '\4';
    EXPECT_EQ(read_npy(file).error().message, "the NPY file must have the version 1, 2 or 3");
}

TEST(NpyReader, ReadsFortranOrder) {
    EXPECT_EQ(values(npy("|u1", "2, 3", "\x00\x03\x01\x04\x02\x05"s, true)), (std::vector<double>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(values(npy("|u1", "2, 1, 2", "\x00\x02\x01\x03"s, true)), (std::vector<double>{0, 1, 2, 3}));
}

TEST(NpyReader, RecognisesTypesThatAreNotNumbers) {
    for (const std::string type : {"<U1", "<c8", "<f6", "|O4", "", "f8", "<M8[ns]"}) {
        const std::string file = npy(type, "0,", "");
        const auto array = read_npy(file);
        EXPECT_FALSE(array && array->has_numbers()) << type;
    }
}

}  // namespace
}  // namespace ccdt::api
