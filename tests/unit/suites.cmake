# The suites of each arithmetic, a file test_SUITE.c each: a line of its own for what takes long or what small cores
# do not hold.  The kernels of compile-time sizes are a suite that most programs leave out.
set(KALMANQ_SUITES_f32 status lengths process sensor lean filter update steps refusals attached sizes full_size smoother on_line delayed wide numbers
    laws changed starts diffuse least_squares consistency learning robust robust_limits watch steady freeze em
    linearised extended sigma_points diffuse_orders diffuse_rank conditions conditions_steps)
set(KALMANQ_SUITES_f64 ${KALMANQ_SUITES_f32})
set(KALMANQ_SUITES_q31 inverse_q31 lengths prepare_q31 model_q31 lean filter_q31 steps refusals attached sizes full_size smoother smoother_q31
    on_line delayed wide numbers laws changed starts diffuse_q31 least_squares consistency learning robust watch
    freeze linearised extended_q31 words_q31 diffuse_orders diffuse_rank conditions conditions_steps conditions_q31)
set(KALMANQ_FIXED_f32 fixed)
set(KALMANQ_FIXED_f64 fixed)
set(KALMANQ_FIXED_q31 fixed)

# kalmanq_tests(FILE LIST ARITHMETIC): writes to LIST a function's body that runs every TEST(name) and
# TEST_KIND(name...) of FILE, but for those of TEST_Q31 and TEST_FLOAT that are not of the arithmetic.
function(kalmanq_tests file list arithmetic)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
  set(kinds "_[A-Z]+")
  if(arithmetic STREQUAL q31)
    set(kinds "_[A-EG-Z][A-Z0-9]+") # not TEST_FLOAT
  endif()
  file(STRINGS "${file}" tests REGEX "^TEST(${kinds})?[(]")
  list(TRANSFORM tests REPLACE "^TEST[A-Z_0-9]*[(]([A-Za-z0-9_]+).*" "    RUN_TEST(\\1)$<SEMICOLON>")
  list(JOIN tests "\n" text)
  string(REPLACE "$<SEMICOLON>" ";" text "${text}")
  file(CONFIGURE OUTPUT "${list}" CONTENT "{\n${text}\n}\n" @ONLY)
endfunction()

# kalmanq_suites(FILES OPTIONS ARITHMETIC WHERE SUITE...): sets the variables with the first two names to
# the files of a runner and their options; its suites.inc and the lists of tests go into the directory WHERE.
function(kalmanq_suites out_files out_options arithmetic where)
  set(unit "${PROJECT_SOURCE_DIR}/tests/unit")
  set(files "${unit}/runner.c")
  set(text)
  foreach(suite IN LISTS ARGN)
    set(file "${unit}/test_${suite}.c")
    list(APPEND files "${file}")
    kalmanq_tests("${file}" "${where}/${suite}.tests" ${arithmetic})
    string(APPEND text "SUITE(${suite})\n")
  endforeach()
  file(CONFIGURE OUTPUT "${where}/suites.inc" CONTENT "${text}" @ONLY)
  string(TOUPPER ${arithmetic} suffix)
  set(${out_files} "${files}" PARENT_SCOPE)
  set(${out_options} -Wdouble-promotion -ffp-contract=off -DKQ_TEST_${suffix} "-I${where}"
      "-I${PROJECT_SOURCE_DIR}/src" PARENT_SCOPE)
endfunction()
