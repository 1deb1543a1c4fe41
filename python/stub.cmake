# Writes AQORB_STUB, the package's stub, with the properties of parameter_table.hpp, and docs.inc, the docstrings of the
# stub's functions for the compiled module. A row of this table has the
# property, the type, the name, the setter's argument as in cv::ORB, the default and, in the next line, the text.
set(table "${CMAKE_CURRENT_LIST_DIR}/../modules/aqorb/src/detector/parameter_table.hpp")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${table}")
file(READ "${table}" rows)
string(REPLACE "\\" "" rows "${rows}")
string(REPLACE ";" "\\;" rows "${rows}")
string(REPLACE "\n" ";" rows "${rows}")
set(AQORB_PROPERTIES "")
foreach(row IN LISTS rows)
  if(row MATCHES "^    X\\(([^,]+), ([^,]+), ([^,]+), ([^,]+), ([^,]+),")
    set(property "${CMAKE_MATCH_1}")
    set(type "${CMAKE_MATCH_2}")
    string(REPLACE "nfeatures" "maxFeatures" argument "${CMAKE_MATCH_4}")
    string(REPLACE "true" "True" default "${CMAKE_MATCH_5}")
    string(REGEX REPLACE "f$" "" default "${default}")
    string(REGEX REPLACE "^.*::.*$" "int" type "${type}")
    string(REPLACE "double" "float" type "${type}")
  elseif(row MATCHES "^      \"(.*)\"\\)")
    string(APPEND AQORB_PROPERTIES
      "    def set${property}(self, ${argument}: ${type}) -> None:\n"
      "        \"\"\"Sets ${CMAKE_MATCH_1}. The default is ${default}.\"\"\"\n"
      "    def get${property}(self) -> ${type}:\n"
      "        \"\"\"Returns ${CMAKE_MATCH_1}.\"\"\"\n")
  endif()
endforeach()
configure_file("${CMAKE_CURRENT_LIST_DIR}/aqorb/__init__.pyi.in" "${AQORB_STUB}" @ONLY)

file(READ "${AQORB_STUB}" stub)
string(REPLACE ";" "<semicolon>" stub "${stub}")
string(REGEX MATCHALL "def [A-Za-z0-9_]+\\([^\"]*\"\"\"[^\"]*\"\"\"" functions "${stub}")
set(docs "")
foreach(function IN LISTS functions)
  string(REGEX REPLACE "\n +" "\n" function "${function}")
  string(REGEX REPLACE "^def ([A-Za-z0-9_]+).*\"\"\"(.*)\"\"\"$" "{\"\\1\", R\"doc(\\2)doc\"},\n" row "${function}")
  string(APPEND docs "${row}")
endforeach()
string(REPLACE "<semicolon>" ";" docs "${docs}")
file(GENERATE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/docs.inc" CONTENT "${docs}")
