# Debian's cross compiler for AQORB_ARCHITECTURE, a name of Debian's, with packages unpacked in AQORB_SYSROOT. Programs
# run under qemu-user. CMakePresets.json and scripts/compatibility.sh use this file.
set(CMAKE_SYSTEM_NAME Linux)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES AQORB_ARCHITECTURE AQORB_SYSROOT)

if(AQORB_ARCHITECTURE STREQUAL "arm64")
  set(CMAKE_SYSTEM_PROCESSOR aarch64)
  set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
elseif(AQORB_ARCHITECTURE STREQUAL "armhf")
  set(CMAKE_SYSTEM_PROCESSOR arm)
  set(CMAKE_LIBRARY_ARCHITECTURE arm-linux-gnueabihf)
  string(APPEND CMAKE_CXX_FLAGS_INIT " -mfpu=neon")  # optional in Debian
elseif(AQORB_ARCHITECTURE MATCHES "^(riscv64|s390x)$")
  set(CMAKE_SYSTEM_PROCESSOR ${AQORB_ARCHITECTURE})
  set(CMAKE_LIBRARY_ARCHITECTURE ${AQORB_ARCHITECTURE}-linux-gnu)
  # Packages of a newer Debian than the compiler's need a newer C library than the compiler's.
  set(CMAKE_EXE_LINKER_FLAGS_INIT -Wl,--allow-shlib-undefined)
else()
  message(FATAL_ERROR "AQORB_ARCHITECTURE is \"${AQORB_ARCHITECTURE}\"; arm64, armhf, riscv64 or s390x is accepted")
endif()

set(CMAKE_C_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-gcc)
set(CMAKE_CXX_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-g++)

set(CMAKE_SYSROOT "${AQORB_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# An environment variable instead of the option -L, which cmake -P would take for its own.
set(CMAKE_CROSSCOMPILING_EMULATOR env "QEMU_LD_PREFIX=${AQORB_SYSROOT}" qemu-${CMAKE_SYSTEM_PROCESSOR}-static)
