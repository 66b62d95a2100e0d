# Builds for the cores: the library for a core, by a compiler, with its options, and what tests link
# with it.  Each object is compiled once and kept; what the core is, cores.sh says.
#
# A build has a name, CORE-COMPILER-LEVEL as m4f-gcc-O2, and its objects are in cores/NAME.

# kalmanq_core_build(BUILD CORE COMPILER OPTION...)
function(kalmanq_core_build build core compiler)
  get_property(is_known GLOBAL PROPERTY KALMANQ_${build}_dir)
  if(is_known)
    return()
  endif()
  get_property(description GLOBAL PROPERTY KALMANQ_CORE_${core}_${compiler})
  if(NOT description)
    execute_process(
      COMMAND sh "${PROJECT_SOURCE_DIR}/tests/target/cores.sh" describe ${core} ${compiler}
      OUTPUT_VARIABLE description COMMAND_ERROR_IS_FATAL ANY)
    set_property(GLOBAL PROPERTY KALMANQ_CORE_${core}_${compiler} "${description}")
  endif()
  string(REGEX MATCHALL "[^\n]+" lines "${description}")
  foreach(line IN LISTS lines)
    string(REGEX MATCH "^([a-z_]+)=(.*)$" is_line "${line}")
    separate_arguments(value UNIX_COMMAND "${CMAKE_MATCH_2}")
    set_property(GLOBAL PROPERTY KALMANQ_${build}_${CMAKE_MATCH_1} "${value}")
  endforeach()
  set(dir "${CMAKE_BINARY_DIR}/cores/${build}")
  file(MAKE_DIRECTORY "${dir}")
  set_property(GLOBAL PROPERTY KALMANQ_${build}_dir "${dir}")
  set_property(GLOBAL PROPERTY KALMANQ_${build}_options "${ARGN}")

  kalmanq_core_load(${build})
  foreach(source IN LISTS sources)
    kalmanq_core_object(${build} "${dir}/${source}.o" "${PROJECT_SOURCE_DIR}/src/${source}"
      -ffp-contract=off ${profile} -Wdouble-promotion)
  endforeach()
endfunction()

# What cores.sh says of the build's core, and its dir and options, as variables
macro(kalmanq_core_load build)
  foreach(key dir options core compiler linker libraries include port sources floating profile)
    get_property(${key} GLOBAL PROPERTY KALMANQ_${build}_${key})
  endforeach()
endmacro()

# kalmanq_core_object(BUILD OBJECT SOURCE FLAG...)
function(kalmanq_core_object build object source)
  kalmanq_core_load(${build})
  get_property(known GLOBAL PROPERTY KALMANQ_${build}_objects)
  if(object IN_LIST known)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY KALMANQ_${build}_objects "${object}")
  get_filename_component(name "${object}" NAME_WLE)
  add_custom_command(OUTPUT "${object}"
    COMMAND ${compiler} ${options} -std=c11 -Wall -Wextra -Wpedantic -Wconversion -Werror ${ARGN}
            ${include} -MMD -MF "${object}.d" -c "${source}" -o "${object}"
    DEPENDS "${source}" DEPFILE "${object}.d" COMMENT "${build}: ${name}" VERBATIM)
endfunction()

# kalmanq_core_library(OUT BUILD REGEX): the library's objects, of files whose names match
function(kalmanq_core_library out build regex)
  kalmanq_core_load(${build})
  list(FILTER sources INCLUDE REGEX "${regex}")
  list(TRANSFORM sources REPLACE "(.+)" "${dir}/\\1.o")
  set(${out} ${sources} PARENT_SCOPE)
endfunction()

# kalmanq_core_program(BUILD NAME OBJECT...): cores/BUILD/NAME
file(GLOB KALMANQ_BOARDS "${PROJECT_SOURCE_DIR}/port/boards/*")
function(kalmanq_core_program build name)
  kalmanq_core_load(${build})
  set_property(GLOBAL PROPERTY KALMANQ_${build}_${name}_linked "${ARGN}")
  add_custom_command(OUTPUT "${dir}/${name}"
    COMMAND ${linker} ${options} ${ARGN} ${libraries} -o "${dir}/${name}"
    DEPENDS ${ARGN} ${KALMANQ_BOARDS} COMMENT "${build}: program ${name}" VERBATIM)
endfunction()

# kalmanq_core_borrow(BUILD OTHER NAME): cores/BUILD/OTHER_NAME, of the objects that OTHER's program NAME has
function(kalmanq_core_borrow build other name)
  get_property(objects GLOBAL PROPERTY KALMANQ_${other}_${name}_linked)
  kalmanq_core_program(${build} ${other}_${name} ${objects})
endfunction()

# kalmanq_core_test(TEST BUILD PROGRAMS [MATRIX]): runs them, one by one
function(kalmanq_core_test test build programs)
  kalmanq_core_load(${build})
  list(TRANSFORM programs PREPEND "${dir}/")
  set(emulator)
  if(core STREQUAL avr)
    set(emulator avr_emulator)
  endif()
  kalmanq_test(${test} ${ARGN} NEEDS ${emulator} ${programs}
    COMMAND sh "${PROJECT_SOURCE_DIR}/tests/target/run.sh" ${core} ${programs})
endfunction()
