// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/domain.h"

namespace ccdt {

/// Returns the bytes of a .shp file of polygons.
/// @param shapes  rings of each shape, which becomes a record; a shape without rings becomes a null record
/// @param type    shape type of the file and its records, by its number in the format
std::string shp_of(const std::vector<std::vector<Ring>>& shapes, int type = 5);

/// A field of a .dbf file.
struct TableField {
    std::string name;
    char type = 'C';
    int width = 1;
};

/// Returns the bytes of a .dbf file.
/// @param rows      [records][fields] values as encoded in the file; padded by spaces
/// @param language  number of the language driver
std::string dbf_of(const std::vector<TableField>& fields, const std::vector<std::vector<std::string>>& rows,
                   int language = 0);

/// Returns the bytes of a zip archive of uncompressed files.
/// @param files  name and content of each
std::string zip_of(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace ccdt
