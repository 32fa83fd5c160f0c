# The library that factorises large finite-element matrices. src/reduction/factor/large_factor_*.cpp are one class, once for
# each of them.

if(MIMBRE_SPARSE_SOLVER STREQUAL "cholmod")
  find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
  find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
  set(include ${CHOLMOD_INCLUDE_DIR})
  set(libraries ${CHOLMOD_LIBRARY})
elseif(MIMBRE_SPARSE_SOLVER STREQUAL "mumps")
  find_path(MUMPS_INCLUDE_DIR dmumps_c.h REQUIRED)
  find_library(MUMPS_LIBRARY dmumps_seq REQUIRED)
  find_library(MPISEQ_LIBRARY mpiseq_seq REQUIRED)
  set(include ${MUMPS_INCLUDE_DIR})
  set(libraries ${MUMPS_LIBRARY} ${MPISEQ_LIBRARY})
elseif(MIMBRE_SPARSE_SOLVER STREQUAL "eigen")
  set(include)
  set(libraries)
else()
  message(FATAL_ERROR "MIMBRE_SPARSE_SOLVER is `${MIMBRE_SPARSE_SOLVER}`; it must be cholmod, mumps or eigen")
endif()

target_sources(mimbre PRIVATE ${PROJECT_SOURCE_DIR}/src/reduction/factor/large_factor_${MIMBRE_SPARSE_SOLVER}.cpp)
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/reduction/factor/large_factor_${MIMBRE_SPARSE_SOLVER}.cpp PROPERTIES
  COMPILE_OPTIONS $<$<CONFIG:Release>:${MIMBRE_WARM_OPTIONS}> SKIP_PRECOMPILE_HEADERS ON)
target_include_directories(mimbre SYSTEM PRIVATE ${include})
target_link_libraries(mimbre PRIVATE ${libraries})
