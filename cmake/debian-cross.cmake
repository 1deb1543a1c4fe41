# Debian's cross compiler for ARM64, with packages unpacked in AQORB_SYSROOT. Programs run under qemu-user.
# CMakePresets.json and scripts/compatibility.sh use this file.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES AQORB_SYSROOT)

set(CMAKE_C_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-gcc)
set(CMAKE_CXX_COMPILER ${CMAKE_LIBRARY_ARCHITECTURE}-g++)

set(CMAKE_SYSROOT "${AQORB_SYSROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# An environment variable instead of the option -L, which cmake -P would take for its own.
set(CMAKE_CROSSCOMPILING_EMULATOR env "QEMU_LD_PREFIX=${AQORB_SYSROOT}" qemu-${CMAKE_SYSTEM_PROCESSOR}-static)
