# The three modules of OpenCV that the library needs, built from OpenCV's source as static archives, for a Python
# package that depends on no installed OpenCV. Sets OpenCV_DIR.
#
# Left out: GUI and codecs, because images come as arrays; TBB, LAPACK, IPP and OpenCL, because the module's own kernels
# do not call them. OpenCV's own pool provides the threads. OpenCV's remaining kernels (conversion to grey, scaling) are
# dispatched up to AVX2.

set(AQORB_OPENCV_SOURCE "" CACHE PATH
  "Folder of OpenCV's source; empty: that of opencv_sources.txt, fetched by pip")
set(AQORB_OPENCV_BUILD "${PROJECT_SOURCE_DIR}/build/pip/opencv" CACHE PATH
  "Folder where OpenCV is built once for the builds of all versions of Python")

set(source "${AQORB_OPENCV_SOURCE}")
set(build "${AQORB_OPENCV_BUILD}/build")
set(prefix "${AQORB_OPENCV_BUILD}/prefix")

# aqorb_run(<what> <command>...): shows its output, so that pip -v is not silent for minutes.
function(aqorb_run what)
  message(STATUS "OpenCV, static: ${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "OpenCV: ${what} failed; the reason stands above")
  endif()
endfunction()

# Checked before OpenCV's build, which takes minutes.
if(AQORB_BUILD_PYTHON)
  find_package(Python 3.9 COMPONENTS Interpreter Development.Module)
  if(NOT Python_FOUND)
    message(FATAL_ERROR "Python's headers were not found. On Debian: apt-get install python3-dev")
  endif()
endif()

file(MAKE_DIRECTORY "${AQORB_OPENCV_BUILD}")
if(NOT source)
  find_package(Python 3.9 REQUIRED COMPONENTS Interpreter)
  set(source "${AQORB_OPENCV_BUILD}/source/opencv")
  aqorb_run(fetch "${CMAKE_COMMAND}" -DPACKAGE=opencv-python-headless -DMAJOR=4 "-DFOLDER=${AQORB_OPENCV_BUILD}"
    "-DPYTHON=${Python_EXECUTABLE}" -P "${CMAKE_CURRENT_LIST_DIR}/fetch_opencv.cmake")
endif()

set(modules core,imgproc,features2d,features)
set(options
  -C "${CMAKE_CURRENT_LIST_DIR}/opencv_options.cmake" -DWITH_JPEG=OFF -DWITH_PNG=OFF
  -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DBUILD_SHARED_LIBS=OFF -DBUILD_LIST=${modules} -DBUILD_ZLIB=ON
  -DBUILD_TESTS=OFF -DBUILD_PERF_TESTS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_JAVA=OFF -DBUILD_opencv_python3=OFF
  -DOPENCV_GENERATE_PKGCONFIG=OFF)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  list(APPEND options -DCPU_BASELINE=SSE2 -DCPU_DISPATCH=SSE4_1,AVX2)
endif()
if(MSVC)
  list(APPEND options -DBUILD_WITH_STATIC_CRT=OFF)  # Python uses the shared runtime
  if(CMAKE_GENERATOR_PLATFORM)
    list(APPEND options -A "${CMAKE_GENERATOR_PLATFORM}")
  endif()
endif()
if(CMAKE_CXX_COMPILER_LAUNCHER)
  list(APPEND options
    "-DCMAKE_C_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}"
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}")
endif()

# The inputs of the archives. Unchanged inputs reuse the archives.
file(SHA256 "${CMAKE_CURRENT_LIST_DIR}/opencv_sources.txt" sources_hash)
file(SHA256 "${CMAKE_CURRENT_LIST_DIR}/opencv_options.cmake" options_hash)
set(made "${source} ${sources_hash}\n${options} ${options_hash}\n${CMAKE_CXX_COMPILER} ${CMAKE_CXX_COMPILER_VERSION}\n")
set(stamp "${prefix}/made")
set(present "")
if(EXISTS "${stamp}")
  file(READ "${stamp}" present)
endif()
if(NOT present STREQUAL made)
  cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
  file(REMOVE_RECURSE "${build}" "${prefix}")
  aqorb_run(configure "${CMAKE_COMMAND}" -S "${source}" -B "${build}" -G "${CMAKE_GENERATOR}"
    "-DCMAKE_MAKE_PROGRAM=${CMAKE_MAKE_PROGRAM}" "-DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}"
    "-DCMAKE_INSTALL_PREFIX=${prefix}" ${options})
  aqorb_run(build "${CMAKE_COMMAND}" --build "${build}" --config Release --parallel ${cores})
  aqorb_run(install "${CMAKE_COMMAND}" --build "${build}" --config Release --target install)
  file(REMOVE_RECURSE "${build}")
  file(WRITE "${stamp}" "${made}")
endif()

file(GLOB_RECURSE config "${prefix}/OpenCVConfig.cmake" "${prefix}/*/OpenCVConfig.cmake")
list(GET config 0 config)
get_filename_component(OpenCV_DIR "${config}" DIRECTORY)
