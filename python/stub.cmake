# Writes AQORB_STUB, the package's stub, with the properties of parameter_table.hpp.
include("${CMAKE_CURRENT_LIST_DIR}/../cmake/AqorbParameters.cmake")
set(AQORB_PROPERTIES "")
foreach(name IN LISTS AQORB_PARAMETER_NAMES)
  string(REGEX REPLACE "^.*::.*$" "int" type "${${name}_TYPE}")
  string(REPLACE "double" "float" type "${type}")
  string(REPLACE "true" "True" default "${${name}_DEFAULT}")
  string(APPEND AQORB_PROPERTIES
    "    def set${${name}_PROPERTY}(self, ${${name}_ARGUMENT}: ${type}) -> None:\n"
    "        \"\"\"Sets ${${name}_TEXT}. The default is ${default}.\"\"\"\n"
    "    def get${${name}_PROPERTY}(self) -> ${type}:\n"
    "        \"\"\"Returns ${${name}_TEXT}.\"\"\"\n")
endforeach()
configure_file("${CMAKE_CURRENT_LIST_DIR}/aqorb/__init__.pyi.in" "${AQORB_STUB}" @ONLY)
