# Fetches a source distribution of opencv_sources.txt from the Python package index, unless it is already there:
#
#   cmake -DPACKAGE=opencv-python-headless -DMAJOR=4 -DFOLDER=FOLDER -DPYTHON=PYTHON -P cmake/fetch_opencv.cmake
#
# FOLDER/source/opencv then has OpenCV's source, and FOLDER/source/opencv_contrib that of opencv_contrib if PACKAGE
# includes it. PYTHON is a Python with pip.
file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/opencv_sources.txt" requirement REGEX "^${PACKAGE}==${MAJOR}\\.")
set(fetched "")
if(EXISTS "${FOLDER}/fetched")
  file(READ "${FOLDER}/fetched" fetched)
endif()
if(fetched STREQUAL requirement)
  return()
endif()
file(REMOVE_RECURSE "${FOLDER}/source")
file(WRITE "${FOLDER}/requirements" "${requirement}")
execute_process(COMMAND "${PYTHON}" -m pip download --disable-pip-version-check --no-deps --no-binary "${PACKAGE}"
  --require-hashes --requirement requirements --dest . WORKING_DIRECTORY "${FOLDER}" RESULT_VARIABLE failed)
file(GLOB archive "${FOLDER}/opencv*.tar.gz")
if(failed OR NOT archive)
  message(FATAL_ERROR "pip could not fetch the source of OpenCV; is there a network?")
endif()
execute_process(COMMAND "${CMAKE_COMMAND}" -E tar xzf "${archive}" WORKING_DIRECTORY "${FOLDER}" RESULT_VARIABLE failed)
string(REGEX REPLACE "\\.tar\\.gz$" "" unpacked "${archive}")
if(failed OR NOT EXISTS "${unpacked}/opencv")
  message(FATAL_ERROR "${archive} could not be unpacked")
endif()
file(RENAME "${unpacked}" "${FOLDER}/source")
file(REMOVE "${archive}")
file(WRITE "${FOLDER}/fetched" "${requirement}")
