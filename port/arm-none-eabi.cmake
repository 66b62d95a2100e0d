# CMake builds the library for Arm without an operating system: the preset `cross`, or
#   cmake -DCMAKE_TOOLCHAIN_FILE=port/arm-none-eabi.cmake -DCMAKE_C_FLAGS="-mthumb -mcpu=cortex-m0" ...
# CMAKE_C_FLAGS says which core.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # a program needs the board's own start-up
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
