# Run-time CPU dispatch of src/<name>.simd.hpp, like ocv_add_dispatched_file in OpenCV's
# cmake/OpenCVCompilerOptimizations.cmake, for a build against an installed OpenCV, which ships the macros but neither
# their configuration nor the CMake part. The same sources serve both builds:
#
#   <name>.simd.hpp         the kernels, between CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN and _END, declared
#                           above #ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY and defined below
#   <name>.dispatch.cpp     includes <name>.simd.hpp and <name>.simd_declarations.hpp and calls
#                           CV_CPU_DISPATCH(kernel, (arguments), CV_CPU_DISPATCH_MODES_ALL)
#
# Only these files see __OPENCV_BUILD, which turns the dispatch macros on.

set(AQORB_DISPATCH_DIR "${CMAKE_CURRENT_LIST_DIR}/dispatch")

# Compiler flags of a CPU feature, and the features it includes, as in OpenCV.
set(AQORB_SSE4_1_FLAGS -mssse3 -msse4.1)
set(AQORB_SSE4_1_FEATURES SSE3 SSSE3 SSE4_1)
set(AQORB_AVX2_FLAGS ${AQORB_SSE4_1_FLAGS} -mpopcnt -msse4.2 -mf16c -mfma -mavx -mavx2)
set(AQORB_AVX2_FEATURES ${AQORB_SSE4_1_FEATURES} POPCNT SSE4_2 FP16 FMA3 AVX AVX2)
set(AQORB_AVX512_SKX_FLAGS ${AQORB_AVX2_FLAGS} -mavx512f -mavx512cd -mavx512vl -mavx512bw -mavx512dq)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 warns of its own avx512fintrin.h.
  list(APPEND AQORB_AVX512_SKX_FLAGS -Wno-uninitialized -Wno-maybe-uninitialized)
endif()
set(AQORB_AVX512_SKX_FEATURES ${AQORB_AVX2_FEATURES} AVX_512F AVX512_COMMON AVX512_SKX)
set(AQORB_AVX512_ICL_FLAGS ${AQORB_AVX512_SKX_FLAGS}
  -mavx512ifma -mavx512vbmi -mavx512vbmi2 -mavx512vnni -mavx512bitalg -mavx512vpopcntdq)
set(AQORB_AVX512_ICL_FEATURES ${AQORB_AVX512_SKX_FEATURES} AVX512_ICL)

# aqorb_add_dispatched_file(<target> <name> [<CPU feature>...])
function(aqorb_add_dispatched_file target name)
  set(features "")
  set(processor "${CMAKE_SYSTEM_PROCESSOR}")
  if(APPLE AND CMAKE_OSX_ARCHITECTURES)
    set(processor "${CMAKE_OSX_ARCHITECTURES}")  # a universal binary gets the baseline only
  endif()
  # OpenCV's AVX2 intrinsics do not compile for 32 bits, and on Windows GCC aligns the stack for SSE2 only.
  if(processor MATCHES "^(x86_64|AMD64)$" AND CMAKE_SIZEOF_VOID_P EQUAL 8
      AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang" AND NOT WIN32)
    set(features ${ARGN})
  endif()

  set(src "${aqorb_module}/src")
  set(generated "${CMAKE_CURRENT_BINARY_DIR}/dispatch")
  set(modes BASELINE)
  set(declarations "#define CV_CPU_SIMD_FILENAME \"${src}/${name}.simd.hpp\"\n")
  set(dispatched "")

  foreach(feature IN LISTS features)
    string(TOLOWER "${feature}" suffix)
    set(file "${generated}/${name}.${suffix}.cpp")
    file(GENERATE OUTPUT "${file}"
      CONTENT "#include \"${src}/precomp.hpp\"\n#include \"${src}/${name}.simd.hpp\"\n")
    target_sources(${target} PRIVATE "${file}")

    list(TRANSFORM AQORB_${feature}_FEATURES REPLACE "(.+)" "CV_CPU_COMPILE_\\1=1" OUTPUT_VARIABLE defines)
    set_source_files_properties("${file}" PROPERTIES
      GENERATED ON
      COMPILE_OPTIONS "${AQORB_${feature}_FLAGS}"
      COMPILE_DEFINITIONS "__OPENCV_BUILD=1;CV_CPU_DISPATCH_MODE=${feature};${defines}"
      INCLUDE_DIRECTORIES "${AQORB_DISPATCH_DIR};${src}")

    string(APPEND declarations
      "#define CV_CPU_DISPATCH_MODE ${feature}\n#include \"cv_cpu_include_simd_declarations.hpp\"\n")
    list(PREPEND modes ${feature})
    list(APPEND dispatched "CV_CPU_DISPATCH_COMPILE_${feature}=1")
  endforeach()

  list(JOIN modes ", " modes)
  string(APPEND declarations "#define CV_CPU_DISPATCH_MODES_ALL ${modes}\n#undef CV_CPU_SIMD_FILENAME\n")
  file(GENERATE OUTPUT "${generated}/${name}.simd_declarations.hpp" CONTENT "${declarations}")

  set_source_files_properties("${src}/${name}.dispatch.cpp" PROPERTIES
    COMPILE_DEFINITIONS "__OPENCV_BUILD=1;${dispatched}"
    INCLUDE_DIRECTORIES "${AQORB_DISPATCH_DIR};${generated}")
endfunction()
