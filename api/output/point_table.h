#pragma once

#include <span>
#include <stop_token>
#include <string>

#include "api/output/body.h"
#include "api/output/ink_dots.h"
#include "api/output/map_dots.h"

namespace ccdt::api {

/// Writes points as comma-separated values (RFC 4180): a header `x,y`, then a line for each; those of inks with names
/// one ink after the other, with a third column `ink`, its name; of points with ranks `rank` is the third; of dots on
/// both sides of the tonal scale the third and fourth are `radius` and `side`, which is ink or paper. Numbers are the
/// shortest that read back to the same double. Stopped, it ends early, with nothing of use.
void write_csv(std::span<const InkDots> inks, Body& body, const std::stop_token& stop = {});

/// Writes points as an array of NumPy, float64 [n, 2]; those of inks with names as [n, 3], last the number of the ink,
/// from 0; those with ranks as [n, 3], last the rank; those on both sides of the tonal scale as [n, 4], with the
/// radius, and 0 for ink or 1 for paper. Source: NEP 1, format version 1.0. Stopped, it ends early, with nothing of
/// use.
void write_npy(std::span<const InkDots> inks, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as comma-separated values, with a third column `feature`, its index, and of classes with
/// names a fourth one `class`; `rank`, if dots have it, stands before these, and properties that are carried behind:
/// texts as they are, objects and arrays as JSON, null as nothing. Stopped, it ends early, with nothing of
/// use.
void write_map_csv(const MapOfDots& map, Body& body, const std::stop_token& stop = {});

/// Writes the dots of a map as an array of NumPy, float64 [n, 3], last the index of the feature; of classes with names
/// [n, 4], last the number of the class, from 0. The rank, if dots have it, is a column before these. Stopped, it ends
/// early, with nothing of use.
void write_map_npy(const MapOfDots& map, Body& body, const std::stop_token& stop = {});

}  // namespace ccdt::api
