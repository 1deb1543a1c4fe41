# Checks that BALANCED_SELECTION still gives the bytes of version 0.1, on scenes that the program draws.
# cmake -DPROGRAM=... [-DEMULATOR=...] -DEXPECTED=... -P balanced.cmake
execute_process(COMMAND ${EMULATOR} "${PROGRAM}" --balanced OUTPUT_VARIABLE printed RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "aqorb_fingerprint failed: ${result}")
endif()
file(READ "${EXPECTED}" expected)
if(NOT printed STREQUAL expected)
  message(FATAL_ERROR "expected, as of version 0.1:\n${expected}\nprinted:\n${printed}")
endif()
