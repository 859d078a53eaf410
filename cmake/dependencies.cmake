# Every library the project uses; each is a Debian package (listed in ./install_packages).
find_package(fmt REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(CLI11 REQUIRED)
find_package(glm REQUIRED)
find_package(Threads REQUIRED)
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)
find_package(assimp REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(WEBP REQUIRED IMPORTED_TARGET libwebp)
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)

# Debian's SystemC carries only the C++17 API symbol; the macro is the documented way to link it from C++20.
find_library(SYSTEMC_LIBRARY systemc REQUIRED)
find_path(SYSTEMC_INCLUDE_DIR systemc REQUIRED)
add_library(systemc INTERFACE)
target_link_libraries(systemc INTERFACE ${SYSTEMC_LIBRARY} Threads::Threads)
target_compile_definitions(systemc INTERFACE SC_CPLUSPLUS=201703L)

# GLSL to SPIR-V and its optimiser, for shader costs. Debian's glslang-config.cmake wants a program of another package,
# and its spirv.pc leaves out a library, so the static libraries are named here, users before what they use.
add_library(shader_compiler INTERFACE)
foreach(name SPIRV glslang glslang-default-resource-limits MachineIndependent GenericCodeGen OSDependent OGLCompiler
        SPIRV-Tools-opt SPIRV-Tools)
  find_library(SHADER_COMPILER_${name} ${name} REQUIRED)
  target_link_libraries(shader_compiler INTERFACE ${SHADER_COMPILER_${name}})
endforeach()
target_link_libraries(shader_compiler INTERFACE Threads::Threads)
