# Common settings of the tests of all folders.
#
# Labels, for ctest -L and CMakePresets.json:
#   unit         accuracy tests in test/
#   concurrency  unit tests with several threads (concurrency or threads in their name)
#   sample, preload, package   each of these programs, run once
#   exports      exported symbols of the shared library
#   soak, fuzz   long runs and valgrind; fuzz targets
#
# Tests of the configuration Long take minutes: ctest runs them with -C Long only.

if(AQORB_BUILD_TESTS OR AQORB_BUILD_FUZZERS)
  enable_testing()
endif()

# GCC 12's thread sanitizer fails with the address randomization of newer kernels. setarch switches it off, unless a
# container forbids it.
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
