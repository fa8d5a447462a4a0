# SPDX-License-Identifier: GPL-3.0-or-later
# Included by ctest: adds a test for each suite of a GoogleTest program or, with each_case, for each case. A process for
# each case would usually take longer to start than the case takes to run.
# Reads: program, each_case, limit (seconds), environment.
execute_process(COMMAND "${program}" --gtest_list_tests OUTPUT_VARIABLE lines RESULT_VARIABLE status)
if(NOT status EQUAL 0)
    add_test("${program}_LISTS_ITS_TESTS" "${program}" --gtest_list_tests)
    return()
endif()
string(REGEX REPLACE " *#[^\n]*" "" lines "${lines}")
string(REGEX MATCHALL "[^\n]+" lines "${lines}")
foreach(line IN LISTS lines)
    if(line MATCHES "^ +(.+)$")
        set(test "${suite}${CMAKE_MATCH_1}")
        set(filter "${test}")
        set(is_wanted ${each_case})
    elseif(line MATCHES "^(.+)\\.$")
        set(suite "${line}")
        set(test "${CMAKE_MATCH_1}")
        set(filter "${suite}*")
        string(COMPARE NOTEQUAL "${each_case}" TRUE is_wanted)
    else()
        continue()  # "Running main() from ..."
    endif()
    if(is_wanted)
        add_test("${test}" "${program}" "--gtest_filter=${filter}" --gtest_brief=1)
        set_tests_properties("${test}" PROPERTIES TIMEOUT "${limit}" ENVIRONMENT "${environment}")
    endif()
endforeach()
