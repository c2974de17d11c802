# SPDX-License-Identifier: Apache-2.0
# The device library, stripped as it is installed, is small. Expects STRIP, LIBRARY, COPY (where to strip it), BYTES_MAX.
execute_process(COMMAND ${STRIP} -o ${COPY} ${LIBRARY} COMMAND_ERROR_IS_FATAL ANY)
file(SIZE ${COPY} bytes)
file(REMOVE ${COPY})
if(bytes GREATER BYTES_MAX)
  message(FATAL_ERROR "${LIBRARY} has ${bytes} bytes stripped, ${BYTES_MAX} are allowed")
endif()
message(STATUS "${bytes} bytes stripped, of ${BYTES_MAX}")
