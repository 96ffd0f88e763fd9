# planegraph_add_viewer(TARGET FOLDER): bundles the 3-D view of FOLDER with three.js into one script and compiles it into
# TARGET. Without Node.js and npm, or without their packages, TARGET gets an empty script, and reports have no 3-D view.
function(planegraph_add_viewer TARGET FOLDER)
  find_program(NODE_EXECUTABLE NAMES node nodejs)
  find_program(NPM_EXECUTABLE npm)
  mark_as_advanced(NODE_EXECUTABLE NPM_EXECUTABLE)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/viewer_script.cc)
  set(work ${CMAKE_CURRENT_BINARY_DIR}/viewer)
  set(with_viewer ${PLANEGRAPH_WITH_VIEWER})
  if(with_viewer AND NOT (NODE_EXECUTABLE AND NPM_EXECUTABLE))
    message(WARNING "Node.js or npm is not here: reports will have no 3-D view")
    set(with_viewer OFF)
  endif()
  # What failed, or was left out, last time gets another chance.
  if(EXISTS ${generated})
    file(READ ${generated} start LIMIT 100)
    if(start MATCHES "no viewer")
      file(REMOVE ${generated})
    endif()
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${FOLDER}/*.js ${FOLDER}/*.mjs ${FOLDER}/*.json)
  set(script ${PROJECT_SOURCE_DIR}/cmake/BuildViewer.cmake)
  add_custom_command(OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} -DWITH_VIEWER=${with_viewer} -DNODE=${NODE_EXECUTABLE} -DNPM=${NPM_EXECUTABLE}
            "-DSOURCES=${sources}" -DWORK=${work} -DOUTPUT=${generated} -P ${script}
    DEPENDS ${sources} ${script} VERBATIM COMMENT "Bundling the report's 3-D view")
  target_sources(${TARGET} PRIVATE ${generated})
  # The standard asks for literals of 64 KiB only; GCC and Clang both take the script's half a megabyte.
  set_source_files_properties(${generated} PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings)
endfunction()
