# SPDX-License-Identifier: Apache-2.0
# cmake -DSWIFT=DIRECTORY -DHEADER=im2fit.h -P swift_names.cmake
# Every name of the C interface in the Swift sources, functions, structs, constants and fields, is in the header: what can
# be told of it without a Swift compiler.
set(swift "")
file(GLOB sources ${SWIFT}/*.swift)
foreach(source IN LISTS sources)
  file(READ ${source} text)
  string(APPEND swift "${text}")
endforeach()
file(READ ${HEADER} header)
string(REGEX MATCHALL "(im2fit|IM2FIT)_[A-Za-z0-9_]+|\\.[a-z0-9]+_[a-z0-9_]+" names "${swift}")
list(REMOVE_DUPLICATES names)
foreach(name IN LISTS names)
  string(REGEX REPLACE "^\\." "" name "${name}")
  if(NOT header MATCHES "[^A-Za-z0-9_]${name}[^A-Za-z0-9_]")
    list(APPEND unknown ${name})
  endif()
endforeach()
list(LENGTH names count)
if(unknown OR count LESS 110)
  message(FATAL_ERROR "${SWIFT}: ${count} names, not in ${HEADER}: ${unknown}")
endif()
message(STATUS "${count} names")
