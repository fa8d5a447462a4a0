# SPDX-License-Identifier: GPL-3.0-or-later
# WebAssembly by Debian's clang 22, libc++ and wasi-libc; docker/packages.txt lists the packages.
set(CMAKE_SYSTEM_NAME WASI)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_CXX_COMPILER clang++-22)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_CXX_FLAGS_INIT -Wno-deprecated)  # Debian's headers are in the folders of the target's old name
