# Read by ctest: makes each GoogleTest suite of PROGRAM one test. A process for every single case would spend most
# of its time on loading libraries.

set(LIST ${PROGRAM}.suites)
if(NOT EXISTS ${PROGRAM})
    add_test(${MODULE} ${PROGRAM}) # fails, and says that there is no such program
    return()
endif()
if(${PROGRAM} IS_NEWER_THAN ${LIST})
    execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE CASES RESULT_VARIABLE STATUS)
    if(NOT STATUS EQUAL 0)
        message(FATAL_ERROR "${PROGRAM} cannot list its tests: ${STATUS}")
    endif()
    string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\.( +#[^\n]*)?\n" SUITES "\n${CASES}")
    list(TRANSFORM SUITES REPLACE "\n([A-Za-z0-9_/]+).*" "\\1\n")
    list(JOIN SUITES "" SUITES)
    file(WRITE ${LIST} "${SUITES}")
endif()
file(STRINGS ${LIST} SUITES)
foreach(SUITE ${SUITES})
    add_test(${MODULE}.${SUITE} ${PROGRAM} --gtest_filter=${SUITE}.*)
    set_tests_properties(${MODULE}.${SUITE} PROPERTIES TIMEOUT 3600)
endforeach()
