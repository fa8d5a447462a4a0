# SPDX-License-Identifier: GPL-3.0-or-later
# Functions that define the installed libraries, and their rules of installation: the component `library` contains what
# programs need to run, `development` what is needed to build programs.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

# Adds a shared library that exports the interface of version 2 only.
#   ccdt_add_shared_library(NAME OUTPUT INTERFACE PART...)
# NAME is the name of the target, after `ccdt::`, for other projects. INTERFACE is an object library with the exported
# functions, and PARTs are static libraries that become part of the shared one.
function(ccdt_add_shared_library name output interface)
    set(target ccdt_${name}_shared)
    add_library(${target} SHARED $<TARGET_OBJECTS:${interface}>)
    add_library(ccdt::${name} ALIAS ${target})
    set(map ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/exports.map)
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} OUTPUT_NAME ${output} LINKER_LANGUAGE CXX
        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR} LINK_DEPENDS ${map})
    target_link_libraries(${target} PRIVATE ccdt_build ${ARGN})
    target_link_options(${target} PRIVATE -Wl,--version-script=${map} -Wl,--as-needed)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>)
    target_compile_features(${target} INTERFACE cxx_std_20)
    install(TARGETS ${target} EXPORT ccdt-targets
        LIBRARY COMPONENT library NAMELINK_COMPONENT development INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

# Adds a static library that contains all objects of the interface and of its parts.
#   ccdt_add_static_library(NAME OUTPUT INTERFACE PART...)
function(ccdt_add_static_library name output interface)
    set(target ccdt_${name}_static)
    list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_OBJECTS:\\1>" OUTPUT_VARIABLE objects)
    add_library(${target} STATIC $<TARGET_OBJECTS:${interface}> ${objects})
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name}_static OUTPUT_NAME ${output} LINKER_LANGUAGE CXX)
    target_compile_features(${target} INTERFACE cxx_std_20)
    install(TARGETS ${target} EXPORT ccdt-static-targets
        ARCHIVE COMPONENT development INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

# Installs a file for pkg-config that finds the prefix relative to itself.
#   ccdt_install_pc(TEMPLATE LIBRARY...)
# Programs that link the static library also need the LIBRARYs.
function(ccdt_install_pc template)
    string(REGEX REPLACE "[^/]+" ".." CCDT_PREFIX ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
    list(TRANSFORM ARGN PREPEND "-l")
    list(JOIN ARGN " " CCDT_LIBRARIES)
    cmake_path(GET template STEM LAST_ONLY file)
    configure_file(${template} ${CMAKE_CURRENT_BINARY_DIR}/${file} @ONLY)
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${file} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT development)
endfunction()

# Installs the CMake package `ccdt`. Must be called after all libraries have been added.
function(ccdt_install_package)
    set(folder ${CMAKE_INSTALL_LIBDIR}/cmake/ccdt)
    configure_package_config_file(${CMAKE_CURRENT_FUNCTION_LIST_DIR}/ccdt-config.cmake.in
        ${CMAKE_CURRENT_BINARY_DIR}/ccdt-config.cmake INSTALL_DESTINATION ${folder})
    write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/ccdt-config-version.cmake
        COMPATIBILITY SameMajorVersion)
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ccdt-config.cmake
        ${CMAKE_CURRENT_BINARY_DIR}/ccdt-config-version.cmake
        DESTINATION ${folder} COMPONENT development)
    foreach(set ccdt-targets ccdt-static-targets)
        install(EXPORT ${set} NAMESPACE ccdt:: DESTINATION ${folder} COMPONENT development)
    endforeach()
endfunction()
