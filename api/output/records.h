// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>
#include <cstddef>
#include <stop_token>
#include <string>

#include "api/output/body.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

// Functions with which the writers of files build lists of records. Binary numbers are little endian.

static_assert(std::endian::native == std::endian::little);

/// Calls write(i) for each record, until a stop or until the sink of the body fails.
template <class Write>
void write_records(std::size_t count, Body& body, const std::stop_token& stop, Write write) {
    constexpr std::size_t kStopStride = 4'096;  // records between two checks of the stop token
    for (std::size_t i = 0; i < count; ++i) {
        if (i % kStopStride == 0 && (!body.flush() || stop.stop_requested())) break;
        write(i);
    }
}

template <class Value>
void append_binary(std::string& out, Value value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline void append_floats(std::string& out, const Point3& p) {
    for (const double ordinate : {p.x, p.y, p.z}) append_binary(out, static_cast<float>(ordinate));
}

inline void append_doubles(std::string& out, const Point3& p) {
    for (const double ordinate : {p.x, p.y, p.z}) append_binary(out, ordinate);
}

}  // namespace ccdt::api
