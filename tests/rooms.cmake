# SPDX-License-Identifier: GPL-3.0-or-later
# Every source file stands in one of these rooms, and includes only from its own room and those before it in the list.
#     cmake -D ROOT=<checkout> -P rooms.cmake
set(rooms
    lib/numerics lib/system lib/equations lib/models lib/flow lib/lanes lib/motion lib/tasks
    floquet/orbit floquet/exponents floquet/attractor floquet/basins floquet/follow floquet/verify
    continuation/trace continuation/problems continuation/conditions continuation/branch continuation/graph
    apps/text apps/console apps/problem apps/quantities apps/results apps/map apps/drawing apps/pictures apps/output apps/published
    apps/commands apps/program)

set(faults "")
foreach(folder lib floquet continuation apps)
  file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/${folder}/*.cpp ${ROOT}/${folder}/*.hpp)
  foreach(source IN LISTS sources)
    get_filename_component(room ${source} DIRECTORY)
    list(FIND rooms ${room} place)
    if(place EQUAL -1)
      string(APPEND faults "${source} stands in no room\n")
      continue()
    endif()
    file(STRINGS ${ROOT}/${source} includes REGEX "^#include <graze/")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE "^#include <graze/([^>]*)/[^>/]*>.*" "\\1" included "${include}")
      list(FIND rooms ${included} other)
      if(other EQUAL -1 OR other GREATER place)
        string(APPEND faults "${source} includes from ${included}\n")
      endif()
    endforeach()
  endforeach()
endforeach()
if(faults)
  message(FATAL_ERROR "${faults}")
endif()
