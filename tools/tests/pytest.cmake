# kalmanq_pytest(PREFIX [FIXTURE...]): a test PREFIX.FILE of each test_FILE.py of the calling folder, in the environment that
# tools.wheel makes, with the modules of this folder beside it.
set(KALMANQ_HOST_TESTS "${CMAKE_CURRENT_LIST_DIR}" CACHE INTERNAL "")
set(KALMANQ_HOST_FILES "${CMAKE_CURRENT_BINARY_DIR}" CACHE INTERNAL "")
set(KALMANQ_CLEAN_PYTHON "${KALMANQ_HOST_FILES}/clean/bin/python" CACHE INTERNAL "")
function(kalmanq_pytest prefix)
  # One filter is compiled in many tests: a compiler that keeps what it makes
  set(with "PATH=path_list_prepend:${KALMANQ_HOST_TESTS}/kept" "KQ_KEPT=set:${KALMANQ_HOST_FILES}/kept"
    "PYTHONPATH=set:${KALMANQ_HOST_TESTS}")
  file(GLOB files CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/test_*.py")
  foreach(file IN LISTS files)
    string(REGEX REPLACE ".*/test_(.*)[.]py" "${prefix}.\\1" name "${file}")
    set(pytest "${KALMANQ_CLEAN_PYTHON}" -B -m pytest -q --no-header -p no:cacheprovider -p whole "${file}" --basetemp
      "${KALMANQ_HOST_FILES}/files/${name}")
    kalmanq_test(${name} COMMAND ${pytest} -m "not whole")
    set_tests_properties(${name} PROPERTIES FIXTURES_REQUIRED "tools.wheel;${ARGN}" ENVIRONMENT_MODIFICATION "${with}")
    file(STRINGS "${file}" marked REGEX "^from whole import")
    if(marked) # what --all adds
      kalmanq_test(${name}.whole MATRIX COMMAND ${pytest}.whole -m whole)
      set_tests_properties(${name}.whole PROPERTIES FIXTURES_REQUIRED "tools.wheel;${ARGN}" ENVIRONMENT_MODIFICATION "${with}")
    endif()
  endforeach()
endfunction()
