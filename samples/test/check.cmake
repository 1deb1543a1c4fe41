# Runs a sample, which must end with EXIT_CODE and write the text MESSAGE:
#   cmake -DEXIT_CODE=1 "-DMESSAGE=cannot be read" -P check.cmake -- PROGRAM ARGUMENT ...
cmake_minimum_required(VERSION 3.16)

set(command "")
set(is_command OFF)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(i RANGE ${last})
  if(is_command)
    list(APPEND command "${CMAKE_ARGV${i}}")
  elseif(CMAKE_ARGV${i} STREQUAL "--")
    set(is_command ON)
  endif()
endforeach()

execute_process(COMMAND ${command} RESULT_VARIABLE exit_code OUTPUT_VARIABLE output ERROR_VARIABLE errors)
message(STATUS "${command}: ${exit_code}\n${output}${errors}")
string(FIND "${output}${errors}" "${MESSAGE}" found)
if(NOT exit_code MATCHES "^(${EXIT_CODE})$" OR found LESS 0)
  message(FATAL_ERROR "did not end with ${EXIT_CODE} and write: ${MESSAGE}")
endif()
