# SPDX-License-Identifier: GPL-3.0-or-later
# Writes the standard output of a program to a file: cmake -DPROGRAM=... -DARGUMENTS=a,b -DOUTPUT=... -P write_output.cmake
string(REPLACE "," ";" arguments "${ARGUMENTS}")
execute_process(COMMAND ${PROGRAM} ${arguments} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
file(WRITE "${OUTPUT}" "${text}")
