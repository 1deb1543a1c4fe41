# Debian's MinGW-w64 with POSIX threads, for 64-bit Windows. Programs run under wine. AQORB_WINDOWS is the folder with
# OpenCV, GoogleTest and the compiler's own libraries for Windows, which scripts/compatibility.sh windows makes.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR AMD64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)

list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES AQORB_WINDOWS)
set(CMAKE_FIND_ROOT_PATH "${AQORB_WINDOWS}" /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# Windows looks for a DLL in the folder of the program, then in those of PATH.
set(CMAKE_CROSSCOMPILING_EMULATOR env WINEDEBUG=-all "WINEPREFIX=${AQORB_WINDOWS}/wine"
  "WINEPATH=Z:${AQORB_WINDOWS}/bin" /usr/lib/wine/wine64)
