# Run by planegraph_add_viewer at build time: fetches the packages of the lock file, bundles, and writes the script as a C++
# source. Never fails: what goes wrong is a warning, and the script is then empty.

function(write_script FIRST_LINE SCRIPT)
  file(WRITE ${OUTPUT} "// ${FIRST_LINE}\n#include \"report/viewer_script.h\"\n\n"
    "const char* const planegraph::kViewerScript = R\"viewer(${SCRIPT})viewer\";\n")
endfunction()

# Sets FAILURE to what went wrong, or to nothing.
macro(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE result OUTPUT_VARIABLE log ERROR_VARIABLE log)
  set(FAILURE "")
  if(NOT result EQUAL 0)
    set(FAILURE "${result}: ${log}")
  endif()
endmacro()

macro(give_up WHY)
  message(WARNING "Reports will have no 3-D view: ${WHY}")
  write_script("no viewer" "")
  return()
endmacro()

if(NOT WITH_VIEWER)
  write_script("no viewer" "")
  return()
endif()

file(COPY ${SOURCES} DESTINATION ${WORK})
# The packages are fetched again only where the lock file has changed.
file(SHA256 ${WORK}/package-lock.json wanted)
set(have "")
if(EXISTS ${WORK}/packages.sha256)
  file(READ ${WORK}/packages.sha256 have)
endif()
if(NOT have STREQUAL wanted)
  run(${NPM} ci --ignore-scripts --no-audit --no-fund --prefer-offline --fetch-retries=1)
  if(FAILURE)
    give_up("npm cannot fetch its packages\n${FAILURE}")
  endif()
  file(WRITE ${WORK}/packages.sha256 ${wanted})
endif()
run(${NODE} bundle.mjs bundle/viewer.js)
if(FAILURE)
  give_up("the bundler failed\n${FAILURE}")
endif()
file(READ ${WORK}/bundle/viewer.js bundle)
string(FIND "${bundle}" ")viewer\"" delimiter)
if(NOT delimiter EQUAL -1)
  give_up("the script holds the end of its own literal")
endif()
write_script("Generated from src/report/viewer: do not edit." "${bundle}")
