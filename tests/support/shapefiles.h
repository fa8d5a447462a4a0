// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/geometry/domain.h"

namespace ccdt {

/// Bytes of a .shp file of polygons: a record for each shape, which is a list of rings; a record without rings is null.
/// @param type  of the file and its records, as the format numbers them
std::string shp_of(const std::vector<std::vector<Ring>>& shapes, int type = 5);

/// Field of a .dbf file.
struct TableField {
    std::string name;
    char type = 'C';
    int width = 1;
};

/// Bytes of a .dbf file.
/// @param rows      texts of each record, as they stand in the file
/// @param language  number of the language driver
std::string dbf_of(const std::vector<TableField>& fields, const std::vector<std::vector<std::string>>& rows,
                   int language = 0);

/// Bytes of a zip archive that holds these files, uncompressed.
std::string zip_of(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace ccdt
