# SPDX-License-Identifier: GPL-3.0-or-later
# Debian packages, one for each component of the install rules: cpack --config build/package/CPackConfig.cmake
#
# Must be included after all install rules. docker/debian/stage.cmake adds the files that only the packages contain.

set(CCDT_MAINTAINER "ccdt maintainers <ccdt@example.org>" CACHE STRING
    "Name and address of the maintainer, which the Debian packages state")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ccdt)
set(CPACK_PACKAGE_CONTACT ${CCDT_MAINTAINER})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
# Several threads would make the bytes of the archives depend on the number of cores.
set(CPACK_THREADS 1)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/docker/debian/stage.cmake)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SOURCE ccdt)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

get_cmake_property(ccdt_components COMPONENTS)
set(CPACK_COMPONENTS_ALL)
set(ccdt_same_version "(= ${PROJECT_VERSION})")
# Lines of a description have at most 79 characters.
set(ccdt_introduction
"ccdt places exactly as many dots as asked for, so that they are evenly spread
and reproduce the tones of a picture or another density. Its method is
Capacity-Constrained Delaunay Triangulation.")

# Describes the package of a component, if the component has install rules.
# Its control files other than `control` are those in docker/debian/PACKAGE.
#   DEPENDS      packages in addition to those of the shared libraries that the files load
#   DESCRIPTION  paragraph that follows the introduction, which all packages have
macro(ccdt_add_package component package)
    cmake_parse_arguments(ARG "" "SECTION;SUMMARY;DESCRIPTION" "DEPENDS;SUGGESTS" ${ARGN})
    if(${component} IN_LIST ccdt_components)
        list(APPEND CPACK_COMPONENTS_ALL ${component})
        string(TOUPPER ${component} prefix)
        string(PREPEND prefix CPACK_DEBIAN_)
        set(${prefix}_PACKAGE_NAME ${package})
        set(${prefix}_PACKAGE_SECTION ${ARG_SECTION})
        list(JOIN ARG_DEPENDS ", " ${prefix}_PACKAGE_DEPENDS)
        list(JOIN ARG_SUGGESTS ", " ${prefix}_PACKAGE_SUGGESTS)
        set(${prefix}_DESCRIPTION "${ARG_SUMMARY}\n${ccdt_introduction}\n\n${ARG_DESCRIPTION}")
        set(${prefix}_PACKAGE_CONTROL_EXTRA)
        file(GLOB controls CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docker/debian/${package}/*)
        foreach(control IN LISTS controls)
            cmake_path(GET control FILENAME name)
            configure_file(${control} ${PROJECT_BINARY_DIR}/debian/${package}/${name} @ONLY)
            list(APPEND ${prefix}_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/${package}/${name})
        endforeach()
    endif()
endmacro()

ccdt_add_package(command ccdt SECTION graphics
    SUMMARY "halftones and evenly spread points by one command"
    DESCRIPTION "This package contains the command ccdt, which reads and writes files."
    DEPENDS "ccdt-decoder ${ccdt_same_version}" fonts-dejavu-core
    SUGGESTS ccdt-server)

ccdt_add_package(server ccdt-server SECTION web
    SUMMARY "halftones and evenly spread points over HTTP"
    DESCRIPTION
"This package contains the server, its web page, and a unit of systemd, which
starts the server on http://127.0.0.1:8080."
    DEPENDS "ccdt-decoder ${ccdt_same_version}" adduser ca-certificates fonts-dejavu-core)

ccdt_add_package(decoder ccdt-decoder SECTION graphics
    SUMMARY "decoder of pictures, maps and meshes for ccdt"
    DESCRIPTION
"This package contains the program that decodes pictures, shapefiles and meshes
in a sandbox, for the packages ccdt and ccdt-server.")

ccdt_add_package(library libccdt2 SECTION libs
    SUMMARY "library for halftones and evenly spread points"
    DESCRIPTION "This package contains the shared libraries."
    DEPENDS fonts-dejavu-core)

ccdt_add_package(development libccdt-dev SECTION libdevel
    SUMMARY "library for halftones and evenly spread points (development files)"
    DESCRIPTION
"This package contains the headers, the static libraries, and the files for
CMake and pkg-config."
    DEPENDS "libccdt2 ${ccdt_same_version}")

ccdt_add_package(python python3-ccdt SECTION python
    SUMMARY "halftones and evenly spread points in Python"
    DESCRIPTION "This package contains the module ccdt for Python 3."
    DEPENDS "python3 (>= 3.11)" "python3 (<< 3.12)" python3-numpy fonts-dejavu-core
    SUGGESTS python3-pil python3-shapely)

include(CPack)
