# Compiles through ccache or sccache where one is installed, so that what was compiled once, in any build folder, is
# copied. Choose another, or none, with -DCMAKE_CXX_COMPILER_LAUNCHER=.
if(NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(MIMBRE_COMPILER_CACHE NAMES ccache sccache)
  mark_as_advanced(MIMBRE_COMPILER_CACHE)
  if(MIMBRE_COMPILER_CACHE MATCHES "/ccache$")
    # With these ccache also looks through precompiled headers (its manual, "Precompiled headers").
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${MIMBRE_COMPILER_CACHE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      add_compile_options(-fpch-preprocess)
    endif()
  elseif(MIMBRE_COMPILER_CACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${MIMBRE_COMPILER_CACHE})
  endif()
endif()
