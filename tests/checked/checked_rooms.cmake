# SPDX-License-Identifier: Apache-2.0
# Every device library must call handlers that stop the program, or its flags were lost: those of overflow, or where it
# adds no signed numbers (person) those of bounds and enumerations. (core counts in unsigned integers,
# whose wrap-round is defined: nothing to handle there.)
foreach(library ${LIBRARIES})
  execute_process(COMMAND ${NM} ${library} OUTPUT_VARIABLE symbols RESULT_VARIABLE status ERROR_QUIET)
  if(status)
    message(FATAL_ERROR "${NM} cannot read ${library}")
  endif()
  if(NOT symbols MATCHES "__ubsan_handle_[a-z_]+_abort")
    message(FATAL_ERROR "${library} is not compiled to stop at integer overflow: see IM2FIT_CHECKED_FIXED")
  endif()
endforeach()
