# Run by the build (EmbedReport.cmake): cmake -DNPM=… -DNODE=… -DWEB=… -DOUTPUT=… -P BuildReport.cmake

# npm leaves this file as the record of what it installed.
set(installed ${WEB}/node_modules/.package-lock.json)
if(NOT EXISTS ${installed} OR ${WEB}/package-lock.json IS_NEWER_THAN ${installed})
  execute_process(COMMAND ${NPM} ci --no-audit --no-fund --loglevel=error WORKING_DIRECTORY ${WEB} RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "npm ci failed in ${WEB}. It needs the network once; to build without the pages, "
      "configure with -DMIMBRE_WITH_REPORT=OFF.")
  endif()
  file(TOUCH ${installed})
endif()

execute_process(COMMAND ${NODE} build.mjs --cpp ${OUTPUT} WORKING_DIRECTORY ${WEB} RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "The pages could not be bundled (node build.mjs in ${WEB}).")
endif()
