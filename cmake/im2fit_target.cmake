# SPDX-License-Identifier: Apache-2.0
# One place for the flags every target of ours shares.
#
# -ffp-contract=off: a fused multiply-add rounds once where two operations round twice. The same frames must
# give the same bits on every machine, so contraction is off everywhere.
function(im2fit_target name)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_compile_options(${name} PUBLIC -ffp-contract=off
                                 PRIVATE -Wall -Wextra -Wconversion -Wno-psabi)
  # GCC 12 sees overlapping copies in "text" + std::string at -O3 where there are none (GCC bug 105651).
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${name} PRIVATE -Wno-restrict)
  endif()
  # GCC stops to look for garbage from 128 MB on; up to a gigabyte it compiles a twentieth quicker without.
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(${name} PRIVATE --param=ggc-min-heapsize=1000000)
  endif()
  # Branchless code joins truths with &. GCC's -Wconversion leaves signs out, and so do we.
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    target_compile_options(${name} PRIVATE -Wno-bitwise-instead-of-logical -Wno-bitwise-conditional-parentheses
                                           -Wno-sign-conversion -Wreserved-identifier)
  endif()
  if(IM2FIT_SANITIZE)
    target_compile_options(${name} PRIVATE -fsanitize=${IM2FIT_SANITIZE} ${im2fit_not_sanitized}
                                           -fno-omit-frame-pointer -fno-sanitize-recover=all)
    target_link_options(${name} PUBLIC -fsanitize=${IM2FIT_SANITIZE})
  endif()
endfunction()

# One optimisation level a library, in every build: what ships is what the tests run. im2fit_level(LEVEL TARGETS...)
#   O3  once a frame or over a whole mesh: a guided frame is 17.4 M instructions at -O3 where -O2 needs 23.9 M
#   Os  once a person or a handle: a quarter smaller, and no frame waits for it
#   O1  once a command or a test: a third less to compile; -O0 with sanitizers, where -O1 takes three times as long
# -fno-math-errno lets the vectoriser take square roots. None of these changes a bit: fused and reordered arithmetic
# are both off. Debug builds keep the build type's level, and so do other levels with sanitizers. A section a function
# lets the linker leave out what the library does not call.
function(im2fit_level level)
  if(IM2FIT_SANITIZE)
    if(level STREQUAL "O1")
      foreach(name ${ARGN})
        target_compile_options(${name} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-O0>)
      endforeach()
    endif()
    return()
  endif()
  foreach(name ${ARGN})
    target_compile_options(${name} PRIVATE $<$<NOT:$<CONFIG:Debug>>:-${level}> -fno-math-errno
                                           -ffunction-sections -fdata-sections)
  endforeach()
endfunction()

# Targets made after this in the directory, and below it, never leave the workstation: arithmetic, whose checks double
# the time to compile, is checked in what ships. Memory is watched everywhere.
macro(im2fit_workstation_code)
  if(im2fit_arithmetic)
    set(im2fit_not_sanitized -fno-sanitize=${im2fit_arithmetic})
  endif()
endmacro()

# Files that IM2FIT_UNITY leaves alone: another of their library or program has a name of theirs, private to each.
function(im2fit_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# The same for some files of a library of another level: im2fit_files_level(LEVEL a.cpp b.cpp), in its folder. The last
# level of a command is the compiler's. They are compiled file by file.
function(im2fit_files_level level)
  im2fit_alone(${ARGN})
  if(NOT IM2FIT_SANITIZE OR level STREQUAL "O1")
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS $<$<NOT:$<CONFIG:Debug>>:-${level}>)
  endif()
endfunction()

# A library of one folder: im2fit_library(NAME LEVEL Os SOURCES a.cpp b.cpp DEPENDS im2fit_core ...). Without SOURCES:
# every *.cpp of the folder, or of its subfolder FOLDER. LOOPS a.cpp b.cpp: those of them that run over every pixel,
# vertex or entry, of level O3.
function(im2fit_library name)
  cmake_parse_arguments(arg "" "FOLDER;LEVEL" "SOURCES;LOOPS;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  if(NOT arg_SOURCES)
    get_filename_component(folder ${CMAKE_CURRENT_SOURCE_DIR}/${arg_FOLDER} ABSOLUTE)
    file(GLOB arg_SOURCES CONFIGURE_DEPENDS ${folder}/*.cpp)
  endif()
  if(arg_LOOPS)
    im2fit_files_level(O3 ${arg_LOOPS})
  endif()
  add_library(${name} STATIC ${arg_SOURCES})
  im2fit_target(${name})
  if(arg_LEVEL)
    im2fit_level(${arg_LEVEL} ${name})
  endif()
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS} PRIVATE ${arg_PRIVATE_DEPENDS})
endfunction()

# One entry of ctest: im2fit_test_entry(NAME PROGRAM [COST N] [FILTER of GoogleTest]). Without FILTER: what the program's
# parts do not run (im2fit_test_part).
function(im2fit_test_entry name program)
  cmake_parse_arguments(arg "" "COST;FILTER" "" ${ARGN})
  set(words --gtest_filter=${arg_FILTER})
  if(NOT arg_FILTER)
    set(parts "$<TARGET_PROPERTY:${program},IM2FIT_PARTS>")
    set(words "$<$<BOOL:${parts}>:--gtest_filter=-$<JOIN:${parts},:>>")
  endif()
  add_test(NAME ${name} COMMAND ${program} "${words}" COMMAND_EXPAND_LISTS)
  # An emulator is ten to fifty times slower.
  if(CMAKE_CROSSCOMPILING)
    set(timeout_s 1500)
  else()
    set(timeout_s 600)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${timeout_s} SKIP_REGULAR_EXPRESSION "NOTHING_TO_TEST")
  if(arg_COST)
    set_tests_properties(${name} PROPERTIES COST "${arg_COST}")
  endif()
  if(IM2FIT_SANITIZE MATCHES thread)
    set_property(TEST ${name} APPEND PROPERTY
      ENVIRONMENT "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/tsan-suppressions.txt")
  endif()
endfunction()

# One GoogleTest program per tests/<room>: im2fit_test_room(ROOM DEPENDS im2fit_kernels ...), takes every *_test.cpp.
# FOLDER NAME: those of a subfolder; the program is built in the folder of that name.
# PROGRAM NAME: NAME_tests instead of ROOM_tests, for a room that is the first part of a program.
# EMULATED_SHARDS N: under an emulator N ctest entries, ROOM_1 to ROOM_N, for rooms that take minutes there.
# COMPUTES: its own loops take longer than what it tests: at -O1 with sanitizers as well.
# COST N: about how many seconds it takes; ctest starts the longest first, so that none is left running alone.
function(im2fit_test_room room)
  cmake_parse_arguments(arg "COMPUTES" "EMULATED_SHARDS;COST;FOLDER;PROGRAM" "DEPENDS" ${ARGN})
  get_filename_component(folder ${CMAKE_CURRENT_SOURCE_DIR}/${arg_FOLDER} ABSOLUTE)
  get_filename_component(built_folder ${CMAKE_CURRENT_BINARY_DIR}/${arg_FOLDER} ABSOLUTE)
  file(GLOB sources CONFIGURE_DEPENDS ${folder}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  set(program ${room}_tests)
  if(arg_PROGRAM)
    set(program ${arg_PROGRAM}_tests)
    set(built_folder ${CMAKE_CURRENT_BINARY_DIR})
  endif()
  add_executable(${program} ${sources})
  set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${built_folder})
  im2fit_target(${program})
  if(arg_COMPUTES)
    target_compile_options(${program} PRIVATE -O1)
  else()
    im2fit_level(O1 ${program})
  endif()
  target_link_libraries(${program} PRIVATE ${arg_DEPENDS} GTest::gtest_main GTest::gmock)
  # One ctest entry a room: starting a process for each case costs more than most cases.
  if(CMAKE_CROSSCOMPILING AND arg_EMULATED_SHARDS)
    foreach(shard RANGE 1 ${arg_EMULATED_SHARDS})
      math(EXPR index "${shard} - 1")
      im2fit_test_entry(${room}_${shard} ${program} COST "${arg_COST}")
      set_property(TEST ${room}_${shard} APPEND PROPERTY
        ENVIRONMENT "GTEST_TOTAL_SHARDS=${arg_EMULATED_SHARDS};GTEST_SHARD_INDEX=${index}")
    endforeach()
  else()
    im2fit_test_entry(${room} ${program} COST "${arg_COST}")
  endif()
endfunction()

# More tests in a program, with a ctest entry of their own: im2fit_test_part(PART PROGRAM FOLDER NAME DEPENDS ...). The
# entry runs the suites of these files and the program's first entry all others, so that no test is left out.
# SOURCES a_test.cpp b_test.cpp: these instead of every *_test.cpp of FOLDER or, without FOLDER, of this folder.
function(im2fit_test_part part program)
  cmake_parse_arguments(arg "" "COST;FOLDER" "SOURCES;DEPENDS" ${ARGN})
  if(NOT arg_SOURCES)
    get_filename_component(folder ${CMAKE_CURRENT_SOURCE_DIR}/${arg_FOLDER} ABSOLUTE)
    file(GLOB arg_SOURCES CONFIGURE_DEPENDS ${folder}/*_test.cpp)
  endif()
  set(suites)
  foreach(source ${arg_SOURCES})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(STRINGS ${source} tests REGEX "^TEST(_[FP])?\\(")
    foreach(test ${tests})
      string(REGEX REPLACE "^[A-Z_]+\\( *([A-Za-z0-9_]+).*" "\\1.*" suite "${test}")
      if(test MATCHES "^TEST_P")
        string(PREPEND suite "*/")
      endif()
      list(APPEND suites ${suite})
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES suites)
  target_sources(${program}_tests PRIVATE ${arg_SOURCES})
  target_link_libraries(${program}_tests PRIVATE ${arg_DEPENDS})
  set_property(TARGET ${program}_tests APPEND PROPERTY IM2FIT_PARTS ${suites})
  list(JOIN suites ":" filter)
  im2fit_test_entry(${part} ${program}_tests COST "${arg_COST}" FILTER ${filter})
endfunction()
