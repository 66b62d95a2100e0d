# What the tests of all houses are made with.  It sets KALMANQ_HAS_TESTS where nothing that they need is missing.
set(KALMANQ_UNITY_DIR "${PROJECT_SOURCE_DIR}/.deps/unity/src" CACHE PATH "Where unity.c is")
option(KALMANQ_FETCH_UNITY "Fetch Unity's pinned release where it is not found" OFF)

# What is missing leaves the tests out, and nothing else: the library needs none of it.
include(CheckLanguage)
check_language(CXX)
set(missing)
if(NOT CMAKE_CXX_COMPILER)
  list(APPEND missing "a C++ compiler")
endif()
if(NOT EXISTS "${KALMANQ_UNITY_DIR}/unity.c" AND NOT KALMANQ_FETCH_UNITY)
  list(APPEND missing Unity)
endif()
if(missing)
  list(JOIN missing ", " missing)
  message(STATUS "kalmanq: all tests are left out, for want of ${missing}; "
                 "tools/test.sh installs what they need and runs them")
  set(KALMANQ_HAS_TESTS OFF)
  return()
endif()
set(KALMANQ_HAS_TESTS ON)

enable_language(CXX)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)

if(NOT EXISTS "${KALMANQ_UNITY_DIR}/unity.c")
  include(FetchContent)
  FetchContent_Declare(unity
    GIT_REPOSITORY https://github.com/ThrowTheSwitch/Unity.git
    GIT_TAG v2.6.0)
  FetchContent_GetProperties(unity)
  if(NOT unity_POPULATED)
    FetchContent_Populate(unity)
  endif()
  set(KALMANQ_UNITY_DIR "${unity_SOURCE_DIR}/src")
endif()
set(KALMANQ_UNITY_FLAGS -DUNITY_INCLUDE_DOUBLE -DUNITY_DOUBLE_PRECISION=1e-12)
add_library(unity STATIC EXCLUDE_FROM_ALL "${KALMANQ_UNITY_DIR}/unity.c")
target_include_directories(unity SYSTEM PUBLIC "${KALMANQ_UNITY_DIR}")
target_compile_options(unity PUBLIC ${KALMANQ_UNITY_FLAGS})

set(KALMANQ_PYTHON python3 CACHE STRING "Interpreter with NumPy, SciPy and Matplotlib")
set(KALMANQ_PEERS_PYTHON "${KALMANQ_PYTHON}" CACHE STRING
    "Interpreter with NumPy, statsmodels and pykalman")
set(KALMANQ_TOOLS_PYTHON "${KALMANQ_PYTHON}" CACHE STRING
    "Interpreter with what the Python package needs, to build and to run, and pytest")
set(KALMANQ_TEST_WARNINGS -Wall -Wextra -Wpedantic -Wconversion -Werror)
set(KALMANQ_AVR_EMULATOR "${CMAKE_BINARY_DIR}/avr_emulator")

# A test takes as long as the machine takes: this is for those that never end.  CTest, the emulators
# and the scripts have no other limit.
set(KALMANQ_TIME_LIMIT 1800 CACHE STRING "Seconds after which a test is one that hangs")
math(EXPR last_resort "${KALMANQ_TIME_LIMIT} + 60") # the test itself stops what it has begun

# The everyday tests of more than ten seconds, the longest first: CTest begins with them, so that none runs alone at the end.
set(KALMANQ_LONG cost.table_and_goals tools.equations tools.compiler tools.design_costs tools.nonlinear_times tools.fixed_device
    tools.commands tools.report tools.design studies.study tools.equation_device tools.fit tools.equation_smoother tools.sensors
    tools.time_columns tools.compiled_runs em.reference target.unit.avr.f32 tools.times tools.campaigns tools.tables
    tools.nonlinear tools.offers reference.random_models studies.examples
    tools.compiled.few tools.compiler_options tools.error_states studies.gallery reference.robust
    house.rules target.unit.m0.q31 unit.msan.f32 reference.adaptation vectors.avr+port-gcc-Os.q31
    reference.nonlinear campaign)

# The core's tests for every day that need a C and a C++ compiler, CMake, Eigen and Python without libraries: the target `alone`
# builds them, and they have that label.
set(KALMANQ_ALONE "^(unit[.]|fuzz[.]|campaign|house[.]|flags[.]gcc|vectors[.](host|falsified|generator)[.]|vectors[.]sanitized|reference[.])")
set(KALMANQ_NOT_ALONE "msan|clang|mutation|^reference[.](steady|continuous|correlated|nonlinear|nonlinear_q31)$")
add_custom_target(alone)

# kalmanq_test(NAME [MATRIX] [FIGURES] [PASS REGEX] [PROCESSORS N] [NEEDS TARGET_OR_FILE...] COMMAND ...)
#   MATRIX   only tools/test.sh --all runs it
#   FIGURES  of a compiler: with another one it says that it is skipped
#   PASS     what the output has to have
#   NEEDS    what is built for it, by the target for.NAME; a COMMAND that is a target is, too
# Its labels are the house, KALMANQ_HOUSE (core, host or shelf), and matrix.
# NumPy has one thread: of matrices as small as these two threads mostly wait for each other, which takes a processor.
function(kalmanq_test name)
  cmake_parse_arguments(PARSE_ARGV 1 my "MATRIX;FIGURES" "PASS;PROCESSORS" "NEEDS;COMMAND")
  add_test(NAME ${name} COMMAND ${my_COMMAND})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${last_resort}
    ENVIRONMENT "KQ_AVR_EMULATOR=${KALMANQ_AVR_EMULATOR};KQ_TIME_LIMIT=${KALMANQ_TIME_LIMIT};OPENBLAS_NUM_THREADS=1")
  list(FIND KALMANQ_LONG ${name} place)
  if(place GREATER -1)
    math(EXPR cost "100 - ${place}")
    set_tests_properties(${name} PROPERTIES COST ${cost})
  endif()
  set(labels ${KALMANQ_HOUSE})
  if(my_MATRIX)
    list(APPEND labels matrix)
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${labels}")
  if(my_FIGURES)
    set_tests_properties(${name} PROPERTIES SKIP_REGULAR_EXPRESSION "skipped: figures are of")
  endif()
  if(my_PASS)
    set_tests_properties(${name} PROPERTIES PASS_REGULAR_EXPRESSION "${my_PASS}")
  endif()
  if(my_PROCESSORS)
    set_tests_properties(${name} PROPERTIES PROCESSORS ${my_PROCESSORS})
  endif()
  list(GET my_COMMAND 0 program)
  if(TARGET ${program})
    list(APPEND my_NEEDS ${program})
  endif()
  add_custom_target(for.${name} DEPENDS ${my_NEEDS})
  if(KALMANQ_HOUSE STREQUAL "core" AND NOT my_MATRIX AND name MATCHES "${KALMANQ_ALONE}" AND NOT name MATCHES "${KALMANQ_NOT_ALONE}")
    set_property(TEST ${name} APPEND PROPERTY LABELS alone)
    add_dependencies(alone for.${name})
  endif()
endfunction()

# The library's own objects as a shared library, for Python
add_library(kalmanq_shared SHARED EXCLUDE_FROM_ALL $<TARGET_OBJECTS:kalmanq>)
set_target_properties(kalmanq_shared PROPERTIES LINKER_LANGUAGE C)
target_link_libraries(kalmanq_shared PRIVATE m)

include("${CMAKE_CURRENT_LIST_DIR}/unit/suites.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/target/cores.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/vectors/recorded.cmake")
