# SPDX-License-Identifier: GPL-3.0-or-later
# Writes a header with the scripts: cmake -DFOLDER=... -DSCRIPTS=common,add,... -DOUTPUT=... -P embed_scripts.cmake
# Each script becomes a string constant with the name of the script.

string(REPLACE "," ";" names "${SCRIPTS}")
set(texts)
foreach(name IN LISTS names)
    file(READ "${FOLDER}/${name}.lua" text)
    string(APPEND texts "inline constexpr std::string_view ${name} = R\"lua(${text})lua\";\n")
endforeach()

file(WRITE "${OUTPUT}" "#pragma once

#include <string_view>

namespace ccdt::server::redis_scripts {

${texts}
}  // namespace ccdt::server::redis_scripts
")
