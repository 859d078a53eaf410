# Warnings, determinism and sanitizers for every target of the project.
add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wno-unknown-warning-option)
# GCC 12 sees overlapping copies in every "text" + std::string at -O3 (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Wno-restrict)
endif()
if(ROPSIM_WERROR)
  add_compile_options(-Werror)
endif()
# Same inputs, same bytes out on any machine: no fused multiply-add that the source does not write.
add_compile_options(-ffp-contract=off)
if(ROPSIM_SANITIZE OR ROPSIM_SANITIZE_THREADS OR ROPSIM_FUZZ)
  # Address space is no measure of memory then. The compilers have different words for it.
  add_compile_definitions(ROPSIM_SHADOW_MEMORY)
endif()
if(ROPSIM_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
if(ROPSIM_SANITIZE_THREADS)
  add_compile_options(-fsanitize=thread -fno-omit-frame-pointer)
  add_link_options(-fsanitize=thread)
endif()
if(ROPSIM_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()

# What a simulation runs through over and over. Its code is larger than a processor's nearest instruction cache: no
# padding in front of loops and jumps. The programs whose speed counts (ropsim_whole_program) are optimised across
# sources; the others, tests above all, link the same objects as they are. Together up to 5 % of a timed run's time.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_BUILD_TYPE STREQUAL Release
   AND NOT (ROPSIM_SANITIZE OR ROPSIM_SANITIZE_THREADS OR ROPSIM_FUZZ))
  set(ROPSIM_ACROSS_SOURCES ON)
else()
  set(ROPSIM_ACROSS_SOURCES OFF)
endif()
function(ropsim_hot_code target)
  if(ROPSIM_ACROSS_SOURCES)
    target_compile_options(${target} PRIVATE -fno-align-jumps -fno-align-loops -fno-align-labels
      -flto -ffat-lto-objects)
  endif()
endfunction()
function(ropsim_whole_program target)
  set_target_properties(${target} PROPERTIES ROPSIM_WHOLE_PROGRAM ${ROPSIM_ACROSS_SOURCES})
endfunction()
if(ROPSIM_ACROSS_SOURCES)
  set(whole "$<BOOL:$<TARGET_PROPERTY:ROPSIM_WHOLE_PROGRAM>>")
  add_link_options("$<${whole}:-O2;-flto=auto>" "$<$<NOT:${whole}>:-fno-lto>")
endif()
