# SPDX-License-Identifier: GPL-3.0-or-later
# Adds the files to the staged packages that only Debian packages contain. CPack runs this script after the install
# rules.

cmake_policy(VERSION 3.25)
set(here ${CMAKE_CURRENT_LIST_DIR})
set(source ${here}/../..)

# The time of the last commit, or of the source archive, makes the packages reproducible. CPack and string(TIMESTAMP)
# read this variable.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
    execute_process(COMMAND git -C ${source} log -1 --format=%ct
        OUTPUT_VARIABLE time OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT time)
        file(TIMESTAMP ${source}/CMakeLists.txt time %s UTC)
    endif()
    set(ENV{SOURCE_DATE_EPOCH} ${time})
endif()

set(file_permissions FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
set(folder_permissions DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# Compresses a file, reproducibly and as the Debian policy requires.
function(compress file)
    execute_process(COMMAND gzip -9nf ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Adds what every package must contain: its licence, the changes of the package, and those of the project.
function(add_documents package root)
    set(folder ${root}/usr/share/doc/${package})
    string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
    configure_file(${here}/changelog.in ${folder}/changelog @ONLY)
    configure_file(${here}/copyright ${folder}/copyright COPYONLY)
    configure_file(${source}/CHANGELOG.md ${folder}/CHANGELOG.md COPYONLY)
    file(CHMOD_RECURSE ${folder} ${file_permissions})
    compress(${folder}/changelog)
    compress(${folder}/CHANGELOG.md)
endfunction()

# Adds the unit of the server, the file of its settings, which lists the variables that the server knows, and the
# description of its operation.
function(add_service root)
    configure_file(${here}/ccdt-server.service ${root}/lib/systemd/system/ccdt-server.service COPYONLY)
    configure_file(${source}/server/README.md ${root}/usr/share/doc/ccdt-server/README.md COPYONLY)
    execute_process(COMMAND ${root}/usr/bin/ccdt-server --help
        COMMAND sed -nE "s/^  --[a-z-]+ [A-Z]+ +([A-Z_]+) +(.*)/\\n# \\u\\2\\n#\\1=/p"
        OUTPUT_VARIABLE variables COMMAND_ERROR_IS_FATAL ANY)
    file(READ ${here}/ccdt-server.default introduction)
    file(WRITE ${root}/etc/default/ccdt-server "${introduction}${variables}")
    file(CHMOD_RECURSE ${root}/etc ${root}/lib ${root}/usr/share ${file_permissions})
    compress(${root}/usr/share/doc/ccdt-server/README.md)
endfunction()

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
    set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component})
    string(TOUPPER ${component} prefix)
    if(component STREQUAL "server")
        add_service(${root})
    endif()
    add_documents(${CPACK_DEBIAN_${prefix}_PACKAGE_NAME} ${root})
    file(CHMOD_RECURSE ${root} ${folder_permissions})
endforeach()
