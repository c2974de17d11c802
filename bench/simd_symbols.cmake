# SPDX-License-Identifier: Apache-2.0
# cmake -DNM=nm -DOBJDUMP=objdump "-DOBJECTS=a.o;b.o" -P simd_symbols.cmake: fails when one of these objects, compiled
# for AVX2, has one of two faults.
#
# A weak function: an inline function or template from a header becomes one in every object that uses it, and the
# linker keeps the copy it meets first: if that is the one compiled for AVX2, a machine without AVX2 runs it and stops.
#
# A function for others that uses whole registers and never clears their upper parts: SSE code that runs after it waits
# for parts it has no use for, and nothing but the time shows it. Compilers clear them by themselves, but not always.
foreach(object ${OBJECTS})
  execute_process(COMMAND ${NM} --defined-only --demangle ${object} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]* W [^\n]*" weak "${symbols}")
  if(weak)
    string(REPLACE ";" "\n  " lines "${weak}")
    message(SEND_ERROR "${object} defines weak functions compiled for AVX2:\n  ${lines}\n"
                       "Use raw pointers and helpers in an anonymous namespace in this file instead.")
  endif()
  execute_process(COMMAND ${NM} --defined-only ${object} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL " T [^\n]*" exported "${symbols}")
  foreach(symbol ${exported})
    string(SUBSTRING "${symbol}" 3 -1 symbol)
    execute_process(COMMAND ${OBJDUMP} --disassemble=${symbol} ${object} OUTPUT_VARIABLE code
                    COMMAND_ERROR_IS_FATAL ANY)
    if(code MATCHES "%ymm" AND NOT code MATCHES "vzeroupper")
      message(SEND_ERROR "${object}: ${symbol} leaves the upper parts of registers in use.\n"
                         "End it with _mm256_zeroupper().")
    endif()
  endforeach()
endforeach()
list(LENGTH OBJECTS count)
message("${count} objects checked")
