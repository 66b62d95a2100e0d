# The text of an arithmetic's operations beside vector.c, which replays them
set(KALMANQ_RECORDED "${CMAKE_CURRENT_LIST_DIR}")
set(KALMANQ_RECORDED_q31 q31)
set(KALMANQ_RECORDED_f32 floats floats_model floats_filter floats_beyond floats_nonlinear)
set(KALMANQ_RECORDED_f64 ${KALMANQ_RECORDED_f32})

# kalmanq_recorded(TARGET MAIN ARITHMETIC LIBRARY FLAG...): a program of the host, MAIN replay or record
function(kalmanq_recorded target main arithmetic library)
  set(files ${main} vector ${KALMANQ_RECORDED_${arithmetic}})
  if(main STREQUAL replay)
    list(APPEND files cases)
  endif()
  list(TRANSFORM files REPLACE "(.+)" "${KALMANQ_RECORDED}/\\1.c")
  add_executable(${target} ${files})
  string(TOUPPER ${arithmetic} suffix)
  target_compile_options(${target} PRIVATE ${KALMANQ_TEST_WARNINGS} -O0 -ffp-contract=off -DVECTOR_${suffix} ${ARGN})
  target_link_libraries(${target} PRIVATE ${library})
  set_target_properties(${target} PROPERTIES C_EXTENSIONS OFF)
endfunction()
