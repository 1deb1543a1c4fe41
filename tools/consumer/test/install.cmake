# Installs the build, moves what was installed, and writes a project and a program of the documents to a folder.
cmake_minimum_required(VERSION 3.16)
file(REMOVE_RECURSE "${INSTALLED}" "${MOVED}" "${EXAMPLE}")
execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${INSTALLED}" RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "cmake --install failed")
endif()
file(RENAME "${INSTALLED}" "${MOVED}")

# The project of installation.md, and the program of README.md.
file(READ "${DOCUMENTS}/doc/installation.md" text)
string(REGEX MATCH "```cmake\n([^`]*project\\(match [^`]*)```" block "${text}")
if(NOT block)
  message(FATAL_ERROR "doc/installation.md shows no project match")
endif()
string(REPEAT "0 " 3072 pixels)
file(WRITE "${EXAMPLE}/black.pgm" "P2 64 48 255 ${pixels}")
file(WRITE "${EXAMPLE}/CMakeLists.txt" "${CMAKE_MATCH_1}enable_testing()\nadd_test(NAME match COMMAND match)\n"
  "set_tests_properties(match PROPERTIES PASS_REGULAR_EXPRESSION \"IMAGE: cannot be read\")\n"
  "add_test(NAME missing COMMAND match missing.png missing.png)\n"
  "set_tests_properties(missing PROPERTIES PASS_REGULAR_EXPRESSION \"missing.png: cannot be read\")\n"
  "add_test(NAME black COMMAND match \"${EXAMPLE}/black.pgm\" \"${EXAMPLE}/black.pgm\")\n"
  "set_tests_properties(black PROPERTIES PASS_REGULAR_EXPRESSION \"0 of 0 matches agree\")\n")
file(READ "${DOCUMENTS}/README.md" text)
string(REGEX MATCH "```cpp\n([^`]*)```" block "${text}")
file(WRITE "${EXAMPLE}/match.cpp" "${CMAKE_MATCH_1}")
