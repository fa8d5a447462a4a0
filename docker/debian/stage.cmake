# SPDX-License-Identifier: GPL-3.0-or-later
# Adds the files that only Debian packages contain to the staged packages. CPack runs this script after the install
# rules.

cmake_policy(VERSION 3.25)
set(here ${CMAKE_CURRENT_LIST_DIR})
set(source ${here}/../..)

# The time of the last commit, or of the source archive, makes the packages reproducible. CPack and string(TIMESTAMP)
# read this variable.
if("$ENV{SOURCE_DATE_EPOCH}" STREQUAL "")
    execute_process(COMMAND git -C ${source} log -1 --format=%ct
        OUTPUT_VARIABLE time OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(NOT time)
        file(TIMESTAMP ${source}/CMakeLists.txt time %s UTC)
    endif()
    set(ENV{SOURCE_DATE_EPOCH} ${time})
endif()

# Compresses files, reproducibly and as the Debian policy requires.
function(compress)
    execute_process(COMMAND gzip -9nf ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Copies a document in Markdown. Replaces links to other files of the source, which packages do not contain, by their
# texts.
function(copy_without_links from to)
    file(READ ${from} text)
    string(REGEX REPLACE "\\[([^]]+)\\]\\([^#):][^):]*\\)" "\\1" text "${text}")
    file(WRITE ${to} "${text}")
endfunction()

# Adds the documents that every package contains: its licence, its changes, and those of the project. Adds its exceptions
# for lintian, if any, and compresses its manual pages.
function(add_documents package root)
    set(folder ${root}/usr/share/doc/${package})
    string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
    configure_file(${here}/changelog.in ${folder}/changelog @ONLY)
    configure_file(${here}/copyright ${folder}/copyright COPYONLY)
    copy_without_links(${source}/CHANGELOG.md ${folder}/CHANGELOG.md)
    if(EXISTS ${here}/${package}.lintian-overrides)
        configure_file(${here}/${package}.lintian-overrides ${root}/usr/share/lintian/overrides/${package} COPYONLY)
    endif()
    file(GLOB pages ${root}/usr/share/man/*/*)
    compress(${folder}/changelog ${folder}/CHANGELOG.md ${pages})
endfunction()

# Adds the unit of the server, the file of its settings, which lists the variables that the server knows, and the
# description of its operation.
function(add_service root)
    configure_file(${here}/ccdt-server.service ${root}/lib/systemd/system/ccdt-server.service COPYONLY)
    copy_without_links(${source}/server/README.md ${root}/usr/share/doc/ccdt-server/README.md)
    execute_process(COMMAND ${root}/usr/bin/ccdt-server --help
        COMMAND sed -nE "s/^  --[a-z-]+ [A-Z]+ +([A-Z_]+) +(.*)/\\n# \\u\\2\\n#\\1=/p"
        OUTPUT_VARIABLE variables COMMAND_ERROR_IS_FATAL ANY)
    file(READ ${here}/ccdt-server.default introduction)
    file(WRITE ${root}/etc/default/ccdt-server "${introduction}${variables}")
    compress(${root}/usr/share/doc/ccdt-server/README.md)
endfunction()

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
    set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component})
    string(TOUPPER ${component} prefix)
    if(component STREQUAL "server")
        add_service(${root})
    endif()
    add_documents(${CPACK_DEBIAN_${prefix}_PACKAGE_NAME} ${root})
    # The modes must not depend on the umask.
    execute_process(COMMAND chmod -R u=rwX,go=rX ${root} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
