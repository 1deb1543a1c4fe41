# What the tests of all folders have in common.
#
# Labels, for ctest -L and CMakePresets.json:
#   unit         the accuracy tests, of test/
#   concurrency  those of them that use several threads (their name says concurrency or threads)
#   sample, preload, package   each of these programs, run once
#   exports      what the shared library exports
#   soak, fuzz   long runs and valgrind; fuzz targets
#
# Tests of the configuration Long take minutes: ctest runs them with -C Long only.

if(AQORB_BUILD_TESTS OR AQORB_BUILD_FUZZERS)
  enable_testing()
endif()

# GCC 12's thread sanitizer cannot cope with the address randomization of newer kernels. A container may forbid to
# switch it off.
if(AQORB_SANITIZE MATCHES "thread" AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
  find_program(AQORB_SETARCH setarch)
  mark_as_advanced(AQORB_SETARCH)
  if(AQORB_SETARCH)
    execute_process(COMMAND "${AQORB_SETARCH}" -R true RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(NOT failed)
      set(CMAKE_CROSSCOMPILING_EMULATOR "${AQORB_SETARCH}" -R)
    endif()
  endif()
endif()
