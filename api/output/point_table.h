#pragma once

#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/geometry/point.h"

namespace ccdt::api {

/// Writes points as comma-separated values (RFC 4180): a header `x,y`, then a line for each. Numbers are the shortest
/// that read back to the same double. Stopped, it ends early, with nothing of use.
std::string write_csv(std::span<const Point> points, const std::stop_token& stop = {});

/// Writes points as an array of NumPy, float64 [n, 2]. Source: NEP 1, format version 1.0.
std::string write_npy(std::span<const Point> points);

/// The points of an ink.
struct InkPoints {
    std::string_view name;
    std::span<const Point> points;
};

/// The same of several inks, one after the other, with a third column `ink`: its name.
std::string write_ink_csv(std::span<const InkPoints> inks, const std::stop_token& stop = {});

/// The same with the number of the ink, from 0: float64 [n, 3].
std::string write_ink_npy(std::span<const InkPoints> inks);

}  // namespace ccdt::api
