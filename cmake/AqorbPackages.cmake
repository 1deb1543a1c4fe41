# Debian packages, one for each component of the installation; see scripts/package.sh and the preset package.
set(AQORB_PACKAGE_CONTACT "The aqorb developers <aqorb@packages.example.org>" CACHE STRING
  "Maintainer of the packages: whoever builds packages for others is to put a name and an address here")

set(soversion "${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
set(files "${CMAKE_CURRENT_LIST_DIR}/debian")
set(made "${CMAKE_CURRENT_BINARY_DIR}/debian")
set(exactly "libaqorb${soversion} (= ${PROJECT_VERSION})")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL runtime development tools preload python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # the OpenCV that the library is tied to, among others
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_BINARY_DIR}/modules/aqorb")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PACKAGE_CONTACT "${AQORB_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # that of SOURCE_DATE_EPOCH, if set
file(WRITE "${made}/changelog" "aqorb (${PROJECT_VERSION}) unstable; urgency=medium

  * Packages made from the source tree by scripts/package.sh.

 -- ${AQORB_PACKAGE_CONTACT}  ${date}
")
find_program(GZIP_PROGRAM gzip REQUIRED)

# compressed(<file>): a file as Debian has its documentation, gzip -9n, in the folder of what was made.
function(compressed file)
  get_filename_component(name "${file}" NAME)
  execute_process(COMMAND "${GZIP_PROGRAM}" -9nc "${file}" OUTPUT_FILE "${made}/${name}.gz" RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "gzip failed for ${file}")
  endif()
endfunction()
compressed("${made}/changelog")

# debian_package(<component> <name> <section> <dependencies> <summary> <description>)
function(debian_package component name section depends summary description)
  string(TOUPPER "${component}" variable)
  set(CPACK_DEBIAN_${variable}_PACKAGE_NAME "${name}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${variable}_PACKAGE_SECTION "${section}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${variable}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${variable}_DESCRIPTION "${summary}
AdaptiveQuadtreeORB is a cv::ORB of OpenCV whose keypoints cover the image
instead of clustering where the contrast is highest. Its descriptors are those
of cv::ORB, so that programs need no other change.
.
${description}" PARENT_SCOPE)
  install(FILES "${files}/copyright" "${made}/changelog.gz" DESTINATION "share/doc/${name}" COMPONENT ${component})
endfunction()

debian_package(runtime "libaqorb${soversion}" libs "" "ORB features spread uniformly over the image - library"
  "This package contains the shared library.")
file(WRITE "${made}/shlibs" "libaqorb ${soversion} libaqorb${soversion} (>= ${PROJECT_VERSION})\n")
file(WRITE "${made}/triggers" "activate-noawait ldconfig\n")  # the library is new in the linker's cache
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA "${made}/triggers;${made}/shlibs")

debian_package(development libaqorb-dev libdevel "${exactly}, libopencv-dev"
  "ORB features spread uniformly over the image - development files"
  "This package contains the headers, the CMake package and the pkg-config file.")

debian_package(tools aqorb-tools utils "${exactly}" "ORB features spread uniformly over the image - programs"
  "This package contains aqorb_demo, which compares the features with those of\ncv::ORB on images.")
install(TARGETS aqorb_demo RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT tools)
compressed("${files}/aqorb_demo.1")
install(FILES "${made}/aqorb_demo.1.gz" DESTINATION share/man/man1 COMPONENT tools)

debian_package(preload aqorb-preload utils "${exactly}"
  "ORB features spread uniformly over the image - in place of cv::ORB"
  "This package contains libaqorb_preload.so: programs that are started with its\nname in LD_PRELOAD get these features from cv::ORB::create.")
# Programs are not linked to it: LD_PRELOAD loads it, by its name alone, from the folder of libraries.
file(WRITE "${made}/aqorb-preload"
  "aqorb-preload: sharedobject-in-library-directory-missing-soname [usr/lib/*/libaqorb_preload.so]\n")
install(FILES "${made}/aqorb-preload" DESTINATION share/lintian/overrides COMPONENT preload)

# The extension module is compiled for one version of Python.
find_package(Python 3.8 REQUIRED COMPONENTS Interpreter)
math(EXPR next_python "${Python_VERSION_MINOR} + 1")
debian_package(python python3-aqorb python
  "${exactly}, python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}~), python3 (<< ${Python_VERSION_MAJOR}.${next_python}), python3-numpy, python3-opencv"
  "ORB features spread uniformly over the image - Python package"
  "This package contains the Python package aqorb, for Debian's python3-opencv,\nand the command python3 -m aqorb. Its draw needs python3-pil. The others also\nneed pyarrow, which Debian does not have.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS python3-pil)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${files}/postinst;${files}/prerm")

include(CPack)
