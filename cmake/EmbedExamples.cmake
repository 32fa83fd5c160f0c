# The models of `mimbre reproduce`: the program carries their files, so that it needs no folder of examples.

function(mimbre_embed_examples target)
  set(files "")
  foreach(name iltis/vehicle.yaml iltis/suspension.yaml iltis/corner.yaml double-four-bar/mechanism.yaml
               spin-up-beam/beam-2d.yaml spin-up-beam/beam-3d.yaml
               solid-arm/suspension.yaml solid-arm/arm.msh)
    set(path ${PROJECT_SOURCE_DIR}/examples/${name})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${path})
    file(READ ${path} text)
    string(APPEND files "    {\"${name}\", R\"yaml(${text})yaml\"},\n")
  endforeach()
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/embedded_examples.cpp)
  file(CONFIGURE OUTPUT ${generated} CONTENT [=[
#include "app/reproduce/reproduce_examples.h"

namespace mimbre::app {

const std::vector<ExampleFile>& embedded_examples() {
  static const std::vector<ExampleFile> files{
@files@  };
  return files;
}

}  // namespace mimbre::app
]=] @ONLY)
  target_sources(${target} PRIVATE ${generated})
endfunction()
