# How every target of ours is compiled: C++20, warnings as errors, the baseline that the binary promises to run on.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)  # the parts are linked into one shared library
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release)
endif()

add_library(pavo_compile_options INTERFACE)
target_compile_options(pavo_compile_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -Wno-missing-field-initializers  # designated initializers leave the rest to the defaults, on purpose
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 sees overlaps in std::string concatenation that are not there (GCC bug 105651)
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>  # sources that are compiled as one (below) look like headers to it
  -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  # Poses are the same to the bit on every run of one SIMD target: the compiler may not contract a*b+c by itself.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # fewer rounds of g++'s garbage collector: a tenth of the time to build
  target_compile_options(pavo_compile_options INTERFACE --param=ggc-min-expand=200 --param=ggc-min-heapsize=524288)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(pavo_compile_options INTERFACE -march=x86-64-v2)
endif()
if(PAVO_SANITIZE)
  target_compile_options(pavo_compile_options INTERFACE
    -fsanitize=${PAVO_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all -g1
    # The instrumented standard library (std::regex above all) looks uninitialised to g++ 12 (GCC bug 105562); the
    # release build keeps the warning.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  if(PAVO_SANITIZE MATCHES "address" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT PAVO_TEST_ALL)
    # What takes g++ long over Eigen: checks for null and for the object's size, which AddressSanitizer finds as well, and
    # for alignment. PAVO_TEST_ALL has them all.
    target_compile_options(pavo_compile_options INTERFACE -fno-sanitize=null,object-size,alignment)
  endif()
  target_link_options(pavo_compile_options INTERFACE -fsanitize=${PAVO_SANITIZE})
endif()

# Several sources are compiled as one, in every build: they read the same large headers, which takes longer than what stands
# in them, and most names that two of them have show where they are written, not days later in CI. (Not all: a constant of
# one source hides that of a header from those behind it, so do not use a header's names for your own.) tools/tidy.sh reads
# each file for itself (test.sh: those of the last commit, with --all every one), and so shows that it includes what it uses.
# Files that are read once per SIMD target (foreach_target.h) stay alone.
if(NOT DEFINED CMAKE_UNITY_BUILD)
  set(CMAKE_UNITY_BUILD ON)
endif()
set(CMAKE_UNITY_BUILD_BATCH_SIZE 6)
function(pavo_keep_simd_files_alone)
  foreach(source ${ARGN})
    file(STRINGS ${source} per_target REGEX "hwy/foreach_target.h" LIMIT_COUNT 1)
    if(per_target)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
endfunction()

# pavo_compile_plainly(TARGET): tests that read options, files and JSON. To optimise that takes a sanitizer's build longer
# than they gain by it. (Not for what the command is made of: the linker takes one copy of each inline function, and that
# of the first object, which would be the slow one.)
function(pavo_compile_plainly target)
  if(PAVO_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()

# pavo_library(NAME [DEPENDENCY...]): a part of the house, made of all sources of the current folder.
# Includes are written from the project's root ("stages/pose/odometry.h").
function(pavo_library name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(NOT sources)  # a folder of headers
    add_library(${name} INTERFACE)
    target_include_directories(${name} INTERFACE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} INTERFACE ${ARGN})
    return()
  endif()
  pavo_keep_simd_files_alone(${sources})
  add_library(${name} STATIC ${sources})
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${ARGN} PRIVATE pavo_compile_options)
endfunction()

if(PAVO_SANITIZE STREQUAL "thread")
  set(pavo_sanitizer_environment "TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/thread_sanitizer.supp")
endif()

# pavo_test(NAME [LIBRARY...]): one test executable, made of all sources of the current folder, one file per behaviour.
# With a sanitizer only those of its tests run that the folder names in pavo_sanitized_tests (GoogleTest's filter), if it
# does; PAVO_TEST_ALL runs all.
function(pavo_test name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE ${ARGN} GTest::gtest_main GTest::gmock pavo_compile_options)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${name} PRIVATE PAVO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(PAVO_SANITIZE)
    pavo_sanitized_shards(${name} ${name})
  else()
    # For the build's time: the libraries that are tested keep their -O3, what stands in headers is tested at -O1.
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT 300)
  endif()
endfunction()

# The same tests in two processes: with a sanitizer, to start one, and to render what its tests share, takes longer than
# most tests do.
function(pavo_sanitized_shards name program)
  set(filter "*")
  if(pavo_sanitized_tests AND NOT PAVO_TEST_ALL)
    set(filter "${pavo_sanitized_tests}")
  endif()
  foreach(shard RANGE 1)
    add_test(NAME ${name}.${shard} COMMAND ${program} --gtest_brief=1 --gtest_filter=${filter})
    set_tests_properties(${name}.${shard} PROPERTIES TIMEOUT 1800
      ENVIRONMENT "GTEST_TOTAL_SHARDS=2;GTEST_SHARD_INDEX=${shard};${pavo_sanitizer_environment};${ARGN}")
  endforeach()
endfunction()

# pavo_benchmark(NAME [LIBRARY...]): one benchmark executable for the question that the current folder asks.
function(pavo_benchmark name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE ${ARGN} pavo_compile_options)
endfunction()
