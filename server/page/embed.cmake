# SPDX-License-Identifier: GPL-3.0-or-later
# Generates a C++ source file that embeds other files:
# cmake -DFILES=path=file,... -DHEADER=... -DFUNCTION=... -DOUTPUT=... -P embed.cmake
# Each file is served at the URL path before its `=`. HEADER declares FUNCTION, which returns the files.

set(type_html "text/html; charset=utf-8")
set(type_css "text/css; charset=utf-8")
set(type_js "text/javascript; charset=utf-8")
set(type_json "application/json")
set(type_geojson "application/geo+json")
set(type_svg "image/svg+xml")
set(type_jpg "image/jpeg")

string(REPLACE "," ";" served "${FILES}")
set(arrays)
set(entries)
set(number 0)
foreach(entry IN LISTS served)
    string(REGEX REPLACE "=.*$" "" path "${entry}")
    string(REGEX REPLACE "^[^=]*=" "" name "${entry}")
    file(READ "${name}" bytes HEX)
    file(SHA256 "${name}" digest)
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
    string(REGEX REPLACE "^.*\\." "" extension "${name}")
    if(NOT DEFINED type_${extension})
        message(FATAL_ERROR "${name}: no media type is known for it")
    endif()
    string(APPEND arrays "const unsigned char content${number}[] = {${bytes}};\n")
    string(APPEND entries "    {\"${path}\", \"${type_${extension}}\", \"${digest}\", text(content${number})},\n")
    math(EXPR number "${number} + 1")
endforeach()

file(WRITE "${OUTPUT}" "#include \"${HEADER}\"

#include <cstddef>

namespace ccdt::server {
namespace {

template <std::size_t size>
std::string_view text(const unsigned char (&bytes)[size]) {
    return {reinterpret_cast<const char*>(bytes), size};
}

${arrays}
const PageFile files[] = {
${entries}};

}  // namespace

std::span<const PageFile> ${FUNCTION}() {
    return files;
}

}  // namespace ccdt::server
")
