# Fails unless a shared library exports the public interface and nothing else:
#
#   cmake -DNM=nm -DLIBRARY=libaqorb.so -P exports.cmake
execute_process(COMMAND "${NM}" --dynamic --demangle --defined-only --format=posix "${LIBRARY}"
  OUTPUT_VARIABLE output RESULT_VARIABLE result)
if(NOT result EQUAL 0 OR output STREQUAL "")
  message(FATAL_ERROR "${NM} lists no symbols of ${LIBRARY}")
endif()

set(class "cv::aqorb::(AdaptiveQuadtreeORB|HammingMatcher|SingleThreadScope)")
set(functions adaptiveFastThreshold distributionOccupancy distributionUniformity retainUniform
  matchArrays knnMatchArrays matchByPosition matchGuided refineMatches growMatches matchImages
  transformKeypoints)
list(TRANSFORM functions PREPEND "cv::aqorb::" OUTPUT_VARIABLE names)
list(JOIN names "|" names)
# A program that derives from the class needs its tables, too. Clang exports those in which the class is constructed.
set(accepted "^(${names})\\(|^((non-)?virtual thunk to )?${class}::~?[A-Za-z]+(\\(|\\[abi)")
string(APPEND accepted "|^(vtable|VTT|typeinfo|typeinfo name) for ${class} |^construction vtable for .*-in-${class} ")

set(unexpected "")
string(REPLACE ";" "," output "${output}")
string(STRIP "${output}" output)
string(REPLACE "\n" ";" symbols "${output}")
foreach(symbol IN LISTS symbols)
  if(NOT symbol MATCHES "${accepted}")
    string(APPEND unexpected "\n  ${symbol}")
  endif()
endforeach()
if(unexpected)
  message(FATAL_ERROR "${LIBRARY} exports more than the public interface:${unexpected}")
endif()

list(TRANSFORM functions APPEND "(" OUTPUT_VARIABLE required)
list(APPEND required "AdaptiveQuadtreeORB::create(" "SingleThreadScope::SingleThreadScope("
  "AdaptiveQuadtreeORB::getDefaultName"
  "HammingMatcher::HammingMatcher(" "HammingMatcher::create(")
foreach(name IN ITEMS AdaptiveQuadtreeORB HammingMatcher)
  list(APPEND required "vtable for cv::aqorb::${name} " "typeinfo for cv::aqorb::${name} ")
endforeach()
foreach(name IN LISTS required)
  string(FIND "${output}" "${name}" position)
  if(position EQUAL -1)
    message(FATAL_ERROR "${LIBRARY} does not export ${name}")
  endif()
endforeach()
list(LENGTH symbols count)
message(STATUS "${count} symbols, all of the public interface")
