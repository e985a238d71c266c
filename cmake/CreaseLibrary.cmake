# Warnings of this project's own targets; never exported. -Wrestrict is off: g++ 12 raises it falsely for
# "literal" + std::string at -O3 (GCC bug 105651).
add_library(crease_warnings INTERFACE)
target_compile_options(crease_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wno-restrict
                                                 -ffp-contract=off)

# crease_add_library(NAME HEADERS.. SOURCES.. [PUBLIC..] [PRIVATE..])
# One static library `crease::NAME`. Its include root is visible only through a link edge, so ranks are enforced by the
# compiler: a header of a library that is not linked cannot be found.
function(crease_add_library name)
  cmake_parse_arguments(ARG "" "" "HEADERS;SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(crease_${name} STATIC ${ARG_SOURCES})
  add_library(crease::${name} ALIAS crease_${name})
  target_sources(crease_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${ARG_HEADERS})
  target_compile_features(crease_${name} PUBLIC cxx_std_20)
  target_link_libraries(crease_${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:crease_warnings>)
  set_target_properties(crease_${name} PROPERTIES EXPORT_NAME ${name} VERIFY_INTERFACE_HEADER_SETS ON
                                                  POSITION_INDEPENDENT_CODE ON)
  install(TARGETS crease_${name} EXPORT creaseTargets FILE_SET HEADERS)
endfunction()

# crease_add_kernels(LIBRARY STEM [OPTIONS..] [WIDE_OPTIONS..])
# Adds src/STEM_generic.cpp and, where the processor may have them, src/STEM_avx2.cpp and src/STEM_avx512.cpp: the same
# loops for one kind of processor each, chosen at run time. Only these files are compiled with its instructions.
# OPTIONS are for all of them, WIDE_OPTIONS for the latter two.
function(crease_add_kernels library stem)
  cmake_parse_arguments(ARG "" "" "OPTIONS;WIDE_OPTIONS" ${ARGN})
  target_sources(crease_${library} PRIVATE src/${stem}_generic.cpp)
  set_source_files_properties(src/${stem}_generic.cpp PROPERTIES COMPILE_OPTIONS "${ARG_OPTIONS}")
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
    target_sources(crease_${library} PRIVATE src/${stem}_avx2.cpp src/${stem}_avx512.cpp)
    set_source_files_properties(src/${stem}_avx2.cpp PROPERTIES
      COMPILE_OPTIONS "-mavx2;${ARG_OPTIONS};${ARG_WIDE_OPTIONS}")
    set_source_files_properties(src/${stem}_avx512.cpp PROPERTIES
      COMPILE_OPTIONS "-mavx512f;-mavx2;${ARG_OPTIONS};${ARG_WIDE_OPTIONS}")
  endif()
endfunction()

# crease_add_test(NAME SOURCES.. LIBS.. [LABELS..]): one GoogleTest program per library, each test its own CTest entry.
function(crease_add_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS;LABELS" ${ARGN})
  if(NOT ARG_LABELS)
    set(ARG_LABELS unit)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} crease_test_support GTest::gtest_main crease_warnings)
  gtest_discover_tests(${name} PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 1500 DISCOVERY_TIMEOUT 60)
endfunction()
