# aqorb_target(<target>): common settings of all targets of the standalone build, not passed on to users of the library.
function(aqorb_target target)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    return()
  endif()

  # The same bytes on every CPU and in every project: arithmetic as written, NaN included, and fused multiply-add only
  # on request of the source. A parent project may compile with -ffast-math.
  target_compile_options(${target} PRIVATE -fno-fast-math -ffp-contract=off)
  # The x87 instructions of 32-bit x86 round to more bits than a float has.
  if(CMAKE_SIZEOF_VOID_P EQUAL 4 AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86|AMD64|i.86")
    target_compile_options(${target} PRIVATE -msse2 -mfpmath=sse)
  endif()

  if(AQORB_WARNINGS)
    # Warnings of OpenCV's cmake/OpenCVCompilerOptions.cmake beyond -Wall and -Wextra.
    target_compile_options(${target} PRIVATE
      -Wall -Wextra -Wnon-virtual-dtor -Wformat-security -Wmissing-declarations -Wundef -Winit-self
      -Wpointer-arith -Wshadow -Wsign-promo -Wno-comment)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -Wsuggest-override -Wno-psabi)  # notes about GCC before 7 on 32-bit ARM
    else()
      target_compile_options(${target} PRIVATE -Winconsistent-missing-override)
    endif()
  endif()
  if(AQORB_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()

  if(AQORB_SANITIZE)
    target_compile_options(${target} PRIVATE
      -fsanitize=${AQORB_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g)
    target_link_options(${target} PRIVATE -fsanitize=${AQORB_SANITIZE})
  endif()
endfunction()
