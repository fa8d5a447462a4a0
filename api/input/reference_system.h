// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace ccdt::api {

/// Coordinate reference system of a map.
struct ReferenceSystem {
    std::string name;
    bool is_lonlat = false;  ///< whether coordinates are longitudes and latitudes in degrees
};

/// Recognises a coordinate reference system by its description, as in .prj files and in the member `crs` of the GeoJSON
/// of 2008: well-known text (WKT, versions 1 and 2), or a name such as `EPSG:3857` or `urn:ogc:def:crs:OGC:1.3:CRS84`.
/// Only the kind and the name of the system are read, not its parameters.
/// @returns  none if the kind is unknown
/// Sources: OGC 01-009, section 7; ISO 19162:2019, 7.3.
std::optional<ReferenceSystem> recognise_reference_system(std::string_view description);

}  // namespace ccdt::api
