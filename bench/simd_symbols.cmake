# SPDX-License-Identifier: Apache-2.0
# cmake -DNM=nm "-DOBJECTS=a.o;b.o" -P simd_symbols.cmake: fails when one of these objects, compiled for AVX2, defines
# a weak function. An inline function or template from a header becomes one in every object that uses it, and the
# linker keeps the copy it meets first: if that is the one compiled for AVX2, a machine without AVX2 runs it and stops.
foreach(object ${OBJECTS})
  execute_process(COMMAND ${NM} --defined-only --demangle ${object} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* W [^\n]*" weak "${symbols}")
  if(weak)
    string(REPLACE ";" "\n  " lines "${weak}")
    message(SEND_ERROR "${object} defines weak functions compiled for AVX2:\n  ${lines}\n"
                       "Use raw pointers and helpers in an anonymous namespace in this file instead.")
  endif()
endforeach()
list(LENGTH OBJECTS count)
message("${count} objects looked at")
