# The page of `mimbre report`: web/ is bundled by npm at build time, and compiled in as one string.

option(MIMBRE_WITH_REPORT "Build the HTML report in (needs npm, Node.js 18 or newer)" ON)

# Adds the generated source to `target`. Without npm, or with the option off, the source holds an empty page and
# report_html() says how to build it in.
function(mimbre_embed_report target)
  set(web ${PROJECT_SOURCE_DIR}/web)
  set(generated ${PROJECT_BINARY_DIR}/report_page.cpp)
  find_program(MIMBRE_NPM npm DOC "npm, bundles the report page")
  find_program(MIMBRE_NODE NAMES node nodejs DOC "Node.js, bundles the report page")
  if(MIMBRE_WITH_REPORT AND MIMBRE_NPM AND MIMBRE_NODE)
    file(GLOB sources CONFIGURE_DEPENDS ${web}/src/*)
    add_custom_command(OUTPUT ${generated}
      COMMAND ${CMAKE_COMMAND} -DNPM=${MIMBRE_NPM} -DNODE=${MIMBRE_NODE} -DWEB=${web} -DOUTPUT=${generated}
        -P ${PROJECT_SOURCE_DIR}/cmake/BuildReport.cmake
      DEPENDS ${sources} ${web}/build.mjs ${web}/package.json ${web}/package-lock.json
        ${PROJECT_SOURCE_DIR}/cmake/BuildReport.cmake
      COMMENT "Bundling the report page" VERBATIM)
  else()
    # Another name: the file of an earlier configuration must not pass for the bundled page.
    set(generated ${PROJECT_BINARY_DIR}/report_page_empty.cpp)
    if(MIMBRE_WITH_REPORT)
      message(WARNING "npm or Node.js not found: `mimbre report` will not work (silence with -DMIMBRE_WITH_REPORT=OFF)")
    endif()
    file(CONFIGURE OUTPUT ${generated} CONTENT [=[
#include "results/report_page.h"

std::string_view mimbre::results::report_page() { return {}; }
]=] @ONLY)
  endif()
  target_sources(${target} PRIVATE ${generated})
endfunction()
