#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/ccdt/ccdt.h"

namespace ccdt::api {

/// Pixels of a picture.
struct PictureSize {
    int width = 0;
    int height = 0;
};

/// What a JSON answer tells besides the points.
struct Report {
    std::uint64_t seed = 0;
    double elapsed_ms = 0;
    std::optional<PictureSize> picture;
};

/// Writes the JSON answer of /sample and /halftone; also the mesh, if there is one. Numbers are the shortest that
/// read back to the same double. Same input, same bytes. About 0.1 microseconds a number.
std::string write_distribution(const Distribution& distribution, const Report& report);

}  // namespace ccdt::api
