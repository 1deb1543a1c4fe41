# Runs a sample, which must end with EXIT_CODE and write the text MESSAGE:
#   cmake "-DCOMMAND=PROGRAM;ARGUMENT..." -DEXIT_CODE=1 "-DMESSAGE=cannot be read" -P check.cmake
cmake_minimum_required(VERSION 3.16)

execute_process(COMMAND ${COMMAND} RESULT_VARIABLE exit_code OUTPUT_VARIABLE output ERROR_VARIABLE output)
message(STATUS "${COMMAND}: ${exit_code}\n${output}")
string(FIND "${output}" "${MESSAGE}" found)
if(NOT exit_code MATCHES "^(${EXIT_CODE})$" OR found LESS 0)
  message(FATAL_ERROR "did not end with ${EXIT_CODE} and write: ${MESSAGE}")
endif()
