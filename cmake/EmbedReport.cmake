# The pages of `mimbre report`, `mimbre live` and `mimbre page`: web/ is bundled by npm at build time, and compiled in as a
# string each.

option(MIMBRE_WITH_REPORT "Build the HTML report and the live page in (needs npm, Node.js 18 or newer)" ON)

# Adds the generated sources to `target`. Without npm, or with the option off, they hold empty pages and report_html()
# says how to build them in.
function(mimbre_embed_report target)
  set(web ${PROJECT_SOURCE_DIR}/web)
  set(generated ${PROJECT_BINARY_DIR}/report_page.cpp ${PROJECT_BINARY_DIR}/live_page.cpp ${PROJECT_BINARY_DIR}/model_page.cpp)
  find_program(MIMBRE_NPM npm DOC "npm, bundles the pages")
  find_program(MIMBRE_NODE NAMES node nodejs DOC "Node.js, bundles the pages")
  if(MIMBRE_WITH_REPORT AND MIMBRE_NPM AND MIMBRE_NODE)
    file(GLOB sources CONFIGURE_DEPENDS ${web}/src/*)
    add_custom_command(OUTPUT ${generated}
      COMMAND ${CMAKE_COMMAND} -DNPM=${MIMBRE_NPM} -DNODE=${MIMBRE_NODE} -DWEB=${web} -DOUTPUT=${PROJECT_BINARY_DIR}
        -P ${PROJECT_SOURCE_DIR}/cmake/BuildReport.cmake
      DEPENDS ${sources} ${web}/build.mjs ${web}/package.json ${web}/package-lock.json
        ${PROJECT_SOURCE_DIR}/cmake/BuildReport.cmake
      COMMENT "Bundling the pages" VERBATIM)
    # The solver of `mimbre page` where scripts/wasm has built it (make page). Another name where not, as below.
    set(wasm ${PROJECT_SOURCE_DIR}/build/wasm/mimbre.wasm)
    if(EXISTS ${wasm})
      add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/page_solver.cpp
        COMMAND ${MIMBRE_NODE} ${web}/embedSolver.mjs ${wasm} ${PROJECT_BINARY_DIR}/page_solver.cpp
        DEPENDS ${wasm} ${web}/embedSolver.mjs COMMENT "Embedding the solver of mimbre page" VERBATIM)
      list(APPEND generated ${PROJECT_BINARY_DIR}/page_solver.cpp)
    else()
      file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/page_solver_empty.cpp CONTENT [=[
#include "live/page_solver.h"

std::string_view mimbre::live::page_solver() { return {}; }
]=] @ONLY)
      list(APPEND generated ${PROJECT_BINARY_DIR}/page_solver_empty.cpp)
    endif()
  else()
    # Another name: the files of an earlier configuration must not pass for the bundled pages.
    set(generated ${PROJECT_BINARY_DIR}/pages_empty.cpp)
    if(MIMBRE_WITH_REPORT)
      message(WARNING "npm or Node.js not found: `mimbre report` and `mimbre live` will have no pages (silence with -DMIMBRE_WITH_REPORT=OFF)")
    endif()
    file(CONFIGURE OUTPUT ${generated} CONTENT [=[
#include "live/live_page.h"
#include "live/page_solver.h"
#include "results/report_page.h"

std::string_view mimbre::live::live_page() { return {}; }
std::string_view mimbre::live::model_page() { return {}; }
std::string_view mimbre::live::page_solver() { return {}; }
std::string_view mimbre::results::report_page() { return {}; }
]=] @ONLY)
  endif()
  target_sources(${target} PRIVATE ${generated})
endfunction()
