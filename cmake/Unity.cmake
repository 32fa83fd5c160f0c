# Compiles the sources of one folder in a few units, so that the headers that they share are parsed and instantiated a
# few times and not by each. Names in unnamed namespaces are therefore unique in their folder: in src/ by their names, in
# tests/ by a namespace for each file.

option(MIMBRE_UNITY "Compile the sources of a folder together: a full build takes half the time" ON)
set(MIMBRE_UNITY_BYTES 90000 CACHE STRING "Most source text in one unit: more is less work in all, and more after an edit")
mark_as_advanced(MIMBRE_UNITY_BYTES)

# Groups the sources of `target` by their folder under src/ or tests/; those after EXCEPT, paths from there, and those with
# options of their own stay alone. Called in the folder that makes the target.
function(mimbre_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 given "" "" EXCEPT)
  if(NOT MIMBRE_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "^${PROJECT_SOURCE_DIR}/(src|tests)/.*\\.cpp$")
  set(rooms)
  foreach(source IN LISTS sources)
    string(REGEX REPLACE "^${PROJECT_SOURCE_DIR}/(src|tests)/" "" path ${source})
    get_source_file_property(options ${source} COMPILE_OPTIONS)
    if(NOT options AND NOT path IN_LIST given_EXCEPT)
      string(REGEX REPLACE "/.*" "" room ${path})
      file(SIZE ${source} bytes)
      math(EXPR bytes_${room} "${bytes_${room}} + ${bytes}")
      list(APPEND sources_${room} ${source})
      list(APPEND rooms ${room})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES rooms)
  foreach(room IN LISTS rooms)
    math(EXPR units "${bytes_${room}} / ${MIMBRE_UNITY_BYTES} + 1")
    set(before 0)
    foreach(source IN LISTS sources_${room})
      math(EXPR unit "${before} * ${units} / ${bytes_${room}}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room}_${unit})
      file(SIZE ${source} bytes)
      math(EXPR before "${before} + ${bytes}")
    endforeach()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # The compiler takes sources that are included for headers, where types of unnamed namespaces have no place.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()
