# make USER_C_MODULES=PATH/kalmanq/port/micropython/micropython.cmake
add_library(usermod_kalmanq INTERFACE)
target_sources(usermod_kalmanq INTERFACE
  "${CMAKE_CURRENT_LIST_DIR}/kalmanq_module.c" "${CMAKE_CURRENT_LIST_DIR}/filter_f32.c" "${CMAKE_CURRENT_LIST_DIR}/status.c")
target_include_directories(usermod_kalmanq INTERFACE "${CMAKE_CURRENT_LIST_DIR}/../../include")
target_compile_options(usermod_kalmanq INTERFACE -fno-math-errno -ffp-contract=off)
target_link_libraries(usermod INTERFACE usermod_kalmanq)
