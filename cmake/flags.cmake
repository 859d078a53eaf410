# Warnings, determinism and sanitizers for every target of the project.
add_compile_options(-Wall -Wextra -Wpedantic -Wshadow -Wno-unknown-warning-option)
if(ROPSIM_WERROR)
  add_compile_options(-Werror)
endif()
# Same inputs, same bytes out on any machine: no fused multiply-add that the source does not write.
add_compile_options(-ffp-contract=off)
if(ROPSIM_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
