# The part of OpenCV's own build that must be included from this folder: OpenCV looks for test/ and
# perf/ beside the file that calls its functions.

# Modules that some of the tests use, and leave out where OpenCV is built without them.
set(test_modules "")
foreach(module opencv_calib3d opencv_flann opencv_stitching)
  if(module IN_LIST OPENCV_MODULES_BUILD)
    list(APPEND test_modules ${module})
  endif()
endforeach()

ocv_add_accuracy_tests(DEPENDS_ON ${test_modules})
ocv_add_perf_tests(DEPENDS_ON opencv_imgcodecs)

if(TARGET opencv_test_aqorb)
  target_include_directories(opencv_test_aqorb PRIVATE "${OPENCV_MODULE_${the_module}_LOCATION}/src")
  ocv_target_include_modules(opencv_test_aqorb ${test_modules})
  ocv_target_link_libraries(opencv_test_aqorb PRIVATE ${test_modules})
  if(CV_GCC OR CV_CLANG)
    # Plain references in the tests round as the module does.
    target_compile_options(opencv_test_aqorb PRIVATE -ffp-contract=off)
  endif()

  # OpenCV's own invariance tests, where its module has them in the form that takes any detector.
  set(features "${OPENCV_MODULE_opencv_${aqorb_features}_LOCATION}")
  if(EXISTS "${features}/test/test_detectors_invariance.impl.hpp")
    target_include_directories(opencv_test_aqorb PRIVATE "${features}/..")
    target_compile_definitions(opencv_test_aqorb PRIVATE AQORB_FEATURES2D_TESTS)
  endif()
endif()

# ocv_add_samples looks in the module's folder only.
if(BUILD_EXAMPLES AND opencv_calib3d IN_LIST OPENCV_MODULES_BUILD
    AND opencv_imgcodecs IN_LIST OPENCV_MODULES_BUILD)
  set(sample_modules ${the_module} ${OPENCV_MODULE_${the_module}_DEPS} opencv_calib3d opencv_imgcodecs)
  ocv_add_executable(example_aqorb_demo "${CMAKE_CURRENT_LIST_DIR}/samples/aqorb_demo.cpp")
  ocv_target_include_modules_recurse(example_aqorb_demo ${sample_modules})
  ocv_target_link_libraries(example_aqorb_demo PRIVATE ${sample_modules})
  if(CV_GCC OR CV_CLANG)
    target_compile_options(example_aqorb_demo PRIVATE -Wno-missing-declarations)  # a program of one file
  endif()
endif()
