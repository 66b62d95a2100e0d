# cmake -DPORT=FOLDER -DWORK=FOLDER -P vcpkg.cmake: a portfile with stand-ins of vcpkg's functions, which no registry has.
# They are strict: what the portfile names has to be there, and a configuration without its own prefix is refused.
cmake_minimum_required(VERSION 3.22)
set(CURRENT_PORT_DIR "${PORT}")
set(CURRENT_PACKAGES_DIR "${WORK}/packages")
set(VCPKG_CURRENT "${WORK}/build")
file(READ "${PORT}/vcpkg.json" manifest)
string(JSON name GET "${manifest}" name)
string(JSON hosts LENGTH "${manifest}" dependencies)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
  if(status)
    message(FATAL_ERROR "${ARGN}: ${said}")
  endif()
endfunction()

function(vcpkg_cmake_configure)
  cmake_parse_arguments(PARSE_ARGV 0 my "" "SOURCE_PATH" "OPTIONS")
  if(my_UNPARSED_ARGUMENTS OR NOT EXISTS "${my_SOURCE_PATH}/CMakeLists.txt")
    message(FATAL_ERROR "vcpkg_cmake_configure: ${my_UNPARSED_ARGUMENTS} ${my_SOURCE_PATH}")
  endif()
  foreach(type Release Debug)
    string(REPLACE "Release" "" below "${type}")
    string(TOLOWER "${below}" below)
    run("${CMAKE_COMMAND}" -S "${my_SOURCE_PATH}" -B "${VCPKG_CURRENT}/${type}" -DCMAKE_BUILD_TYPE=${type} ${my_OPTIONS}
        "-DCMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR}/${below}" -DFETCHCONTENT_FULLY_DISCONNECTED=ON)
  endforeach()
endfunction()

function(vcpkg_cmake_install)
  foreach(type Release Debug)
    run("${CMAKE_COMMAND}" --build "${VCPKG_CURRENT}/${type}" --target install -j2)
  endforeach()
endfunction()

function(vcpkg_cmake_config_fixup)
  cmake_parse_arguments(PARSE_ARGV 0 my "" "PACKAGE_NAME;CONFIG_PATH" "")
  set(found "${CURRENT_PACKAGES_DIR}/${my_CONFIG_PATH}")
  set(to "${CURRENT_PACKAGES_DIR}/share/${my_PACKAGE_NAME}")
  if(NOT EXISTS "${found}/${my_PACKAGE_NAME}Config.cmake")
    message(FATAL_ERROR "vcpkg_cmake_config_fixup: ${found} has no configuration")
  endif()
  file(COPY "${found}/" DESTINATION "${to}")
  file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/lib/cmake" "${CURRENT_PACKAGES_DIR}/debug/lib/cmake")
  file(READ "${to}/${my_PACKAGE_NAME}Config.cmake" text) # one folder less above it
  string(REPLACE [[get_filename_component(_IMPORT_PREFIX "${CMAKE_CURRENT_LIST_FILE}" PATH)
get_filename_component(_IMPORT_PREFIX "${_IMPORT_PREFIX}" PATH)]]
    [[get_filename_component(_IMPORT_PREFIX "${CMAKE_CURRENT_LIST_FILE}" PATH)]] text "${text}")
  file(WRITE "${to}/${my_PACKAGE_NAME}Config.cmake" "${text}")
endfunction()

function(vcpkg_fixup_pkgconfig)
  if(NOT EXISTS "${CURRENT_PACKAGES_DIR}/lib/pkgconfig/${name}.pc")
    message(FATAL_ERROR "vcpkg_fixup_pkgconfig: there is no ${name}.pc")
  endif()
endfunction()

function(vcpkg_install_copyright)
  cmake_parse_arguments(PARSE_ARGV 0 my "" "" "FILE_LIST")
  file(COPY_FILE "${my_FILE_LIST}" "${CURRENT_PACKAGES_DIR}/share/${name}/copyright")
endfunction()

include("${PORT}/portfile.cmake")

# What vcpkg looks for afterwards
foreach(there share/${name}/copyright share/${name}/${name}Config.cmake include/kalmanq/kalmanq.h lib/libkalmanq.a
    debug/lib/libkalmanq.a)
  if(NOT EXISTS "${CURRENT_PACKAGES_DIR}/${there}")
    message(FATAL_ERROR "the port leaves no ${there}")
  endif()
endforeach()
if(EXISTS "${CURRENT_PACKAGES_DIR}/debug/include")
  message(FATAL_ERROR "the port leaves headers in debug/")
endif()
message(STATUS "${name}: the portfile makes a package (${hosts} host dependencies)")
