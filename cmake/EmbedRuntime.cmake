# The library as FMUs take it along (`mimbre fmu --library`): what compiles and steps a model, without what reads files,
# as a shared library of C functions, whose bytes are a source of `target`.
function(mimbre_embed_runtime target)
  set(generated ${PROJECT_BINARY_DIR}/runtime_bytes.cpp)
  set_source_files_properties(${generated} PROPERTIES INCLUDE_DIRECTORIES ${PROJECT_SOURCE_DIR}/src)
  target_sources(${target} PRIVATE ${generated})
  if(NOT CMAKE_SYSTEM_NAME STREQUAL "Linux" OR MIMBRE_SANITIZE)
    file(CONFIGURE OUTPUT ${generated} @ONLY CONTENT [=[
#include "portable/library/library_code.h"

std::span<const unsigned char> mimbre::portable::runtime_bytes() { return {}; }
]=])
    return()
  endif()
  # An archive, from which the linker takes what is needed.
  add_library(mimbre_core STATIC ${MIMBRE_PARTS})
  set_target_properties(mimbre_core PROPERTIES LINKER_LANGUAGE CXX)
  add_library(mimbre_runtime SHARED ${PROJECT_SOURCE_DIR}/src/portable/library/runtime.cpp)
  set_target_properties(mimbre_runtime PROPERTIES CXX_VISIBILITY_PRESET hidden NO_SONAME ON
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}
    BUILD_RPATH "$ORIGIN")  # where FMUs have what it needs
  target_include_directories(mimbre_runtime PRIVATE include src)
  target_compile_definitions(mimbre_runtime PRIVATE ${MIMBRE_EIGEN_ABI} ${MIMBRE_FORMAT_CHECK})
  target_compile_options(mimbre_runtime PRIVATE $<$<CONFIG:Release>:${MIMBRE_COLD_OPTIONS}>)
  # It shares no function with the program that loads it, which may be another version of this library.
  target_link_options(mimbre_runtime PRIVATE LINKER:--exclude-libs,ALL,--gc-sections,--no-undefined,-Bsymbolic
    $<$<CONFIG:Release>:-s>)
  target_link_libraries(mimbre_runtime PRIVATE mimbre_options mimbre_core Eigen3::Eigen fmt::fmt)
  # The assembler reads the file: written as numbers it would take the compiler minutes.
  set(file $<TARGET_FILE:mimbre_runtime>)
  set(text [=[
#include "portable/library/library_code.h"

asm(".pushsection .rodata\n"
    ".balign 16\n"
    "mimbre_runtime_first: .incbin \"@file@\"\n"
    "mimbre_runtime_last: .byte 0\n"
    ".popsection\n");
extern "C" const unsigned char mimbre_runtime_first[], mimbre_runtime_last[];

std::span<const unsigned char> mimbre::portable::runtime_bytes() {
  return {mimbre_runtime_first, mimbre_runtime_last};
}
]=])
  string(CONFIGURE "${text}" text @ONLY)
  file(GENERATE OUTPUT ${generated} CONTENT "${text}")
  set_source_files_properties(${generated} PROPERTIES OBJECT_DEPENDS ${PROJECT_BINARY_DIR}/libmimbre_runtime.so)
endfunction()
