# planegraph_add_module(NAME DEPENDS targets...): the module NAME from src/NAME/*.cc and include/planegraph/NAME.
# A module links only what lies below it, so an include that goes up does not link.
function(planegraph_add_module NAME)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${NAME}/*.cc)
  set(target planegraph_${NAME})
  if(NOT sources)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE planegraph_options ${ARG_DEPENDS})
    return()
  endif()
  add_library(${target} STATIC ${sources})
  add_library(Planegraph::${NAME} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${NAME})
  target_include_directories(${target}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${target} PUBLIC planegraph_options ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
  set_property(GLOBAL APPEND PROPERTY PLANEGRAPH_MODULES ${target})
endfunction()

# planegraph_add_tests(NAME DEPENDS targets...): one test program from tests/NAME/*_test.cc.
function(planegraph_add_tests NAME)
  cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/${NAME}/*_test.cc)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${NAME} ${sources})
  target_include_directories(test_${NAME} PRIVATE ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(test_${NAME} PRIVATE ${ARG_DEPENDS} planegraph_options GTest::gmock GTest::gtest_main)
  target_compile_definitions(test_${NAME} PRIVATE
    PLANEGRAPH_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data"
    PLANEGRAPH_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data")
  gtest_discover_tests(test_${NAME} TEST_PREFIX ${NAME}. DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
endfunction()
