# The program that calls FMUs in a process of their own (src/fmu/process): small, and compiled in as bytes, so that the
# library finds it wherever it is used from.
function(mimbre_embed_fmu_process target)
  add_executable(mimbre_fmu_process src/fmu/process/main.cpp src/fmu/calls.cpp src/fmu/plan.cpp)
  target_include_directories(mimbre_fmu_process PRIVATE src)
  target_compile_options(mimbre_fmu_process PRIVATE $<$<CONFIG:Release>:-O2>)
  find_package(Threads REQUIRED)
  target_link_libraries(mimbre_fmu_process PRIVATE mimbre_options Threads::Threads ${CMAKE_DL_LIBS})
  target_link_options(mimbre_fmu_process PRIVATE $<$<CONFIG:Release>:-s>)
  set(generated ${PROJECT_BINARY_DIR}/fmu_process_bytes.cpp)
  add_custom_command(OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} -DINPUT=$<TARGET_FILE:mimbre_fmu_process> -DOUTPUT=${generated}
      -P ${PROJECT_SOURCE_DIR}/cmake/EmbedBytes.cmake
    DEPENDS mimbre_fmu_process ${PROJECT_SOURCE_DIR}/cmake/EmbedBytes.cmake
    COMMENT "Embedding the program that calls FMUs" VERBATIM)
  target_sources(${target} PRIVATE ${generated})
  set_source_files_properties(${generated} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
endfunction()
