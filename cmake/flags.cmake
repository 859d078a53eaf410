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

# The code that a machine goes through for every request is larger than a processor's nearest instruction cache:
# no padding in front of its loops and jumps (1.5 % of a timed run's time, docs/bench.md).
function(ropsim_without_padding target)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    target_compile_options(${target} PRIVATE -fno-align-jumps -fno-align-loops -fno-align-labels)
  endif()
endfunction()
