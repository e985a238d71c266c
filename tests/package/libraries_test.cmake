# Run by ctest: with CREASE_BUILD_APPS off, all libraries are there, the stepper too, and the program is not.
file(REMOVE_RECURSE ${WORK})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK} -G ${GENERATOR} -D CREASE_BUILD_APPS=OFF -D CREASE_BUILD_TESTS=OFF
                OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${WORK} --target help OUTPUT_VARIABLE targets COMMAND_ERROR_IS_FATAL ANY)
foreach(library base geometry solver collision dynamics remesh constraints stepper)
  if(NOT targets MATCHES "crease_${library}: phony")
    message(FATAL_ERROR "no target crease_${library}")
  endif()
endforeach()
if(targets MATCHES "\ncrease: phony")
  message(FATAL_ERROR "the program is built all the same")
endif()
