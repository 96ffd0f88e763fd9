# One interface target carries what every target of ours is compiled with.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

add_library(planegraph_options INTERFACE)
target_compile_features(planegraph_options INTERFACE cxx_std_20)
target_compile_options(planegraph_options INTERFACE
  "$<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wnon-virtual-dtor;-Woverloaded-virtual>")
if(CMAKE_UNITY_BUILD)
  # GCC takes what it includes for headers, and warns of classes with members of a type that only one source knows.
  target_compile_options(planegraph_options INTERFACE $<BUILD_INTERFACE:-Wno-subobject-linkage>)
endif()
if(PLANEGRAPH_WARNINGS_AS_ERRORS)
  target_compile_options(planegraph_options INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(PLANEGRAPH_SANITIZE)
  target_compile_options(planegraph_options INTERFACE
    "$<BUILD_INTERFACE:-fsanitize=${PLANEGRAPH_SANITIZE};-fno-omit-frame-pointer;-fno-sanitize-recover=all>")
  target_link_options(planegraph_options INTERFACE $<BUILD_INTERFACE:-fsanitize=${PLANEGRAPH_SANITIZE}>)
endif()
if(PLANEGRAPH_COVERAGE)
  target_compile_options(planegraph_options INTERFACE $<BUILD_INTERFACE:--coverage>)
  target_link_options(planegraph_options INTERFACE $<BUILD_INTERFACE:--coverage>)
endif()
