# Options for cmake -C: leaves out of OpenCV's build the parts that the module and its tests do not need, and all parts
# that OpenCV would download.
foreach(feature 1394 ADE CAROTENE EIGEN FFMPEG FLATBUFFERS GSTREAMER GTK IPP ITT JASPER KLEIDICV LAPACK OPENCL OPENEXR
    OPENJPEG PROTOBUF QUIRC TBB TIFF V4L VA VA_INTEL VTK WEBP)
  set(WITH_${feature} OFF CACHE BOOL "" FORCE)
endforeach()
set(CMAKE_BUILD_TYPE Release CACHE STRING "")
set(BUILD_opencv_apps OFF CACHE BOOL "")
set(ENABLE_CCACHE OFF CACHE BOOL "")  # the compiler launcher already uses ccache
set(OPENCV_DOWNLOAD_TRIES_LIST "" CACHE STRING "")
