# Files into the program. As a script, cmake -DOUTPUT=FILE.cpp -DINPUTS=FILE,FILE -P embed.cmake writes their
# bytes as C++: a/stillsData.js as recurse::page::STILLS_DATA_JS. Included, recurse_embed(TARGET FILE...) does
# so at build time.

if(CMAKE_SCRIPT_MODE_FILE)
    set(TEXT "#include \"report/page/embedded.h\"\nnamespace recurse::page {\n")
    string(REPLACE "," ";" INPUTS "${INPUTS}")
    foreach(INPUT ${INPUTS})
        get_filename_component(NAME ${INPUT} NAME)
        string(REGEX REPLACE "([a-z])([A-Z])" "\\1_\\2" NAME ${NAME})
        string(REPLACE "." "_" NAME ${NAME})
        string(TOUPPER ${NAME} NAME)
        file(READ ${INPUT} BYTES HEX)
        string(REGEX REPLACE "(................................)" "\\1\n" BYTES "${BYTES}")
        string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," BYTES "${BYTES}")
        string(APPEND TEXT "static const unsigned char ${NAME}_BYTES[] = {\n${BYTES}};\n"
            "const std::string_view ${NAME}(reinterpret_cast<const char*>(${NAME}_BYTES),\n"
            "                               sizeof ${NAME}_BYTES);\n")
    endforeach()
    file(WRITE ${OUTPUT} "${TEXT}}\n")
    return()
endif()

set(RECURSE_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})
function(recurse_embed TARGET)
    set(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/embedded/${TARGET}.cpp)
    set(INPUTS)
    foreach(FILE ${ARGN})
        get_filename_component(FILE ${FILE} ABSOLUTE)
        list(APPEND INPUTS ${FILE})
    endforeach()
    list(JOIN INPUTS "," JOINED)
    add_custom_command(OUTPUT ${OUTPUT}
        COMMAND ${CMAKE_COMMAND} -DOUTPUT=${OUTPUT} -DINPUTS=${JOINED} -P ${RECURSE_EMBED_SCRIPT}
        DEPENDS ${INPUTS} ${RECURSE_EMBED_SCRIPT} VERBATIM)
    target_sources(${TARGET} PRIVATE ${OUTPUT})
endfunction()
