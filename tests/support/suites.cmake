# SPDX-License-Identifier: GPL-3.0-or-later
# Included by ctest: adds one test for each suite of a GoogleTest program. The processes of single cases would take longer
# to start than the cases take to run. Reads: program, limit (seconds), environment.
execute_process(COMMAND "${program}" --gtest_list_tests OUTPUT_VARIABLE lines RESULT_VARIABLE status)
if(NOT status EQUAL 0)
    add_test("${program}_LISTS_ITS_TESTS" "${program}" --gtest_list_tests)
    return()
endif()
string(REGEX MATCHALL "(^|\n)[A-Za-z0-9_/]+\\." suites "${lines}")
foreach(suite IN LISTS suites)
    string(REGEX REPLACE "^\n|\\.$" "" suite "${suite}")
    add_test("${suite}" "${program}" "--gtest_filter=${suite}.*" --gtest_brief=1)
    set_tests_properties("${suite}" PROPERTIES TIMEOUT "${limit}" ENVIRONMENT "${environment}")
endforeach()
