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
if(ROPSIM_SANITIZE OR ROPSIM_FUZZ)
  add_compile_definitions(ROPSIM_ADDRESS_SANITIZER)  # the compilers have different words for it
endif()
if(ROPSIM_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
if(ROPSIM_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
