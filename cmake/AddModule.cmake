# planegraph_add_module(NAME DEPENDS targets... PRIVATE_DEPENDS targets...): the module NAME from src/NAME/*.cc and
# include/planegraph/NAME, installed as Planegraph::NAME. Without sources it is a library of headers.
# A module links only what lies below it, so an include that goes up does not link (tests/layering says so earlier).
function(planegraph_add_module NAME)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${NAME}/*.cc)
  set(target planegraph_${NAME})
  if(sources)
    set(visibility PUBLIC)
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(${target} PRIVATE ${ARG_PRIVATE_DEPENDS})
  else()
    set(visibility INTERFACE)
    add_library(${target} INTERFACE)
  endif()
  target_include_directories(${target} ${visibility}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(${target} ${visibility} planegraph_options ${ARG_DEPENDS})
  planegraph_export(${target} ${NAME})
endfunction()

# planegraph_export(TARGET NAME): installs the library TARGET with the package, where it is called Planegraph::NAME.
function(planegraph_export TARGET NAME)
  add_library(Planegraph::${NAME} ALIAS ${TARGET})
  set_target_properties(${TARGET} PROPERTIES EXPORT_NAME ${NAME})
  set_property(GLOBAL APPEND PROPERTY PLANEGRAPH_MODULES ${TARGET})
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
  # Tests are many small functions that run once: compiling them fast matters more.
  target_compile_options(test_${NAME} PRIVATE $<$<CONFIG:Release>:-O1>)
  target_link_libraries(test_${NAME} PRIVATE ${ARG_DEPENDS} planegraph_options GTest::gmock GTest::gtest_main)
  target_compile_definitions(test_${NAME} PRIVATE
    PLANEGRAPH_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data"
    PLANEGRAPH_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data")
  gtest_discover_tests(test_${NAME} TEST_PREFIX ${NAME}. NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
endfunction()
