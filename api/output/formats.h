#pragma once

#include "api/input/negotiation.h"

namespace ccdt::api {

/// What answers can be made as; each endpoint makes some of these.
inline constexpr Format kJson = {"json", "application/json"};
inline constexpr Format kCsv = {"csv", "text/csv", "; header=present"};
inline constexpr Format kGeoJson = {"geojson", "application/geo+json"};
inline constexpr Format kNpy = {"npy", "application/x-npy"};  // NumPy has registered none
inline constexpr Format kSvg = {"svg", "image/svg+xml"};
inline constexpr Format kPng = {"png", "image/png"};
inline constexpr Format kWebP = {"webp", "image/webp"};
inline constexpr Format kTiff = {"tiff", "image/tiff"};

}  // namespace ccdt::api
