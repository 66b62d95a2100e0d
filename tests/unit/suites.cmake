# The suites of each arithmetic: a line of its own for what takes long or what small cores do not hold.
set(KALMANQ_SUITES_f32 status lengths process sensor lean filter update forecast smoother numbers laws changed lag
    watch instant diffuse least_squares consistency adaptation robust steady em extended sigma_points diffuse_orders diffuse_rank)
set(KALMANQ_SUITES_f64 ${KALMANQ_SUITES_f32})
set(KALMANQ_SUITES_q31 inverse lengths prepare model lean filter smoother views numbers laws on_line diffuse least_squares
    consistency adaptation robust watch steady extended words diffuse_orders diffuse_rank)

# kalmanq_suites(FILES OPTIONS ARITHMETIC WHERE SUITE...): sets the variables with the first two names to
# the files of a runner and their options; its suites.inc goes into the directory WHERE.
function(kalmanq_suites out_files out_options arithmetic where)
  set(unit "${PROJECT_SOURCE_DIR}/tests/unit")
  set(files "${unit}/runner.c")
  set(text)
  foreach(suite IN LISTS ARGN)
    set(file "${unit}/test_${suite}_${arithmetic}.c")
    if(NOT EXISTS "${file}")
      set(file "${unit}/test_${suite}.c")
    endif()
    list(APPEND files "${file}")
    string(APPEND text "SUITE(${suite})\n")
  endforeach()
  file(CONFIGURE OUTPUT "${where}/suites.inc" CONTENT "${text}" @ONLY)
  string(TOUPPER ${arithmetic} suffix)
  set(${out_files} "${files}" PARENT_SCOPE)
  set(${out_options} -Wdouble-promotion -ffp-contract=off -DKQ_TEST_${suffix} "-I${where}"
      "-I${PROJECT_SOURCE_DIR}/src" PARENT_SCOPE)
endfunction()
