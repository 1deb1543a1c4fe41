# Labels the tests of aqorb_test. ctest includes this file after it has listed them.
foreach(test IN LISTS aqorb_test_TESTS)
  set(labels unit)
  if(test MATCHES "concurrency|threads")
    list(APPEND labels concurrency)
  endif()
  set_tests_properties("${test}" PROPERTIES LABELS "${labels}")
endforeach()
