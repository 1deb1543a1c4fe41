# The three modules of OpenCV that the library needs, built from OpenCV's source as static archives, for a Python
# package that depends on no installed OpenCV, and for WebAssembly. Sets OpenCV_DIR.
#
# What is left out: GUI and codecs, because images come as arrays; TBB, LAPACK, IPP and OpenCL, because the module's
# own kernels do the work and call none of them. The threads are those of OpenCV's own pool; WebAssembly has none. The
# kernels of OpenCV that remain (conversion to grey, scaling) are dispatched up to AVX2.

set(AQORB_OPENCV_RELEASE 4.14.0.94)
set(sha256 4afa2ea1214453648be88259f035712454faa9039b686de7753569ba8eec1577)
set(AQORB_OPENCV_SOURCE "" CACHE PATH
  "Folder of OpenCV's source; empty: the source distribution of opencv-python-headless ${AQORB_OPENCV_RELEASE}, fetched by pip")
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

# Asked for first, before minutes are spent on OpenCV.
if(AQORB_BUILD_PYTHON)
  find_package(Python 3.9 COMPONENTS Interpreter Development.Module)
  if(NOT Python_FOUND)
    message(FATAL_ERROR "Python's headers were not found. On Debian: apt-get install python3-dev")
  endif()
endif()

file(MAKE_DIRECTORY "${AQORB_OPENCV_BUILD}")
if(NOT source)
  set(folder "opencv_python_headless-${AQORB_OPENCV_RELEASE}")
  set(source "${AQORB_OPENCV_BUILD}/${folder}/opencv")
  if(NOT EXISTS "${AQORB_OPENCV_BUILD}/fetched-${AQORB_OPENCV_RELEASE}")
    find_package(Python 3.9 REQUIRED COMPONENTS Interpreter)
    aqorb_run(fetch "${Python_EXECUTABLE}" -m pip download --no-deps --no-binary opencv-python-headless
      --dest "${AQORB_OPENCV_BUILD}" "opencv-python-headless==${AQORB_OPENCV_RELEASE}")
    set(archive "${AQORB_OPENCV_BUILD}/${folder}.tar.gz")
    file(SHA256 "${archive}" found)
    if(NOT found STREQUAL sha256)
      message(FATAL_ERROR "${archive} is not what was expected: its SHA256 is ${found} instead of ${sha256}")
    endif()
    aqorb_run(unpack "${CMAKE_COMMAND}" -E chdir "${AQORB_OPENCV_BUILD}" "${CMAKE_COMMAND}" -E tar xzf "${archive}")
    file(REMOVE "${archive}")
    file(WRITE "${AQORB_OPENCV_BUILD}/fetched-${AQORB_OPENCV_RELEASE}" "")
  endif()
endif()

set(modules core,imgproc,features2d,features)
set(options
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_POSITION_INDEPENDENT_CODE=ON
  -DBUILD_SHARED_LIBS=OFF -DBUILD_LIST=${modules} -DBUILD_ZLIB=ON
  -DBUILD_TESTS=OFF -DBUILD_PERF_TESTS=OFF -DBUILD_EXAMPLES=OFF -DBUILD_opencv_apps=OFF -DBUILD_JAVA=OFF
  -DBUILD_opencv_python3=OFF
  -DENABLE_CCACHE=OFF -DOPENCV_DOWNLOAD_TRIES_LIST= -DOPENCV_GENERATE_PKGCONFIG=OFF)
foreach(feature 1394 ADE CAROTENE EIGEN FFMPEG FLATBUFFERS GSTREAMER GTK IPP ITT JASPER JPEG KLEIDICV LAPACK OPENCL
    OPENEXR OPENJPEG PNG PROTOBUF QUIRC TBB TIFF V4L VA VA_INTEL VTK WEBP)
  list(APPEND options "-DWITH_${feature}=OFF")
endforeach()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  list(APPEND options -DCPU_BASELINE=SSE2 -DCPU_DISPATCH=SSE4_1,AVX2)
endif()
if(MSVC)
  list(APPEND options -DBUILD_WITH_STATIC_CRT=OFF)  # Python's is the shared one
  if(CMAKE_GENERATOR_PLATFORM)
    list(APPEND options -A "${CMAKE_GENERATOR_PLATFORM}")
  endif()
elseif(APPLE)
  list(APPEND options "-DCMAKE_OSX_ARCHITECTURES=${CMAKE_OSX_ARCHITECTURES}"
    "-DCMAKE_OSX_DEPLOYMENT_TARGET=${CMAKE_OSX_DEPLOYMENT_TARGET}")
endif()
if(CMAKE_CROSSCOMPILING)
  list(APPEND options "-DCMAKE_TOOLCHAIN_FILE=${CMAKE_TOOLCHAIN_FILE}" "-DCMAKE_SYSTEM_NAME=${CMAKE_SYSTEM_NAME}"
    "-DCMAKE_SYSTEM_PROCESSOR=${CMAKE_SYSTEM_PROCESSOR}")
endif()
if(CMAKE_CXX_COMPILER_LAUNCHER)
  list(APPEND options
    "-DCMAKE_C_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}"
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${CMAKE_CXX_COMPILER_LAUNCHER}")
endif()

# The inputs of the archives. Unchanged inputs reuse the archives.
set(made "${source}\n${options}\n${CMAKE_CXX_COMPILER} ${CMAKE_CXX_COMPILER_VERSION}\n")
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
