// glslang's front end and SPIRV-Tools' optimiser, both as libraries.
#include "capture/shader_cost/shader_compiler.h"

#include "base/error.h"

#include <mutex>
#include <string_view>

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <glslang/SPIRV/spirv.hpp>
#include <glslang/build_info.h>
#include <spirv-tools/libspirv.h>
#include <spirv-tools/optimizer.hpp>

namespace ropsim {
namespace {

constexpr std::size_t kHeaderWords = 5;

SpirvWords to_spirv(const std::string& label, const std::string& glsl) {
    static std::once_flag once;
    std::call_once(once, [] { glslang::InitializeProcess(); });
    const char* text = glsl.c_str();
    glslang::TShader shader(EShLangFragment);
    shader.setStrings(&text, 1);
    shader.setEnvInput(glslang::EShSourceGlsl, EShLangFragment, glslang::EShClientOpenGL, 100);
    shader.setEnvClient(glslang::EShClientOpenGL, glslang::EShTargetOpenGL_450);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_0);
    // OpenGL links varyings and uniforms by name; SPIR-V wants numbers, any will do.
    shader.setAutoMapLocations(true);
    constexpr int kVersion = 450;
    const bool parsed = shader.parse(GetDefaultResources(), kVersion, false, EShMsgSpvRules);
    CHECK(parsed, "shader of {}: {}", label, shader.getInfoLog());
    glslang::TProgram program;
    program.addShader(&shader);
    const bool linked = program.link(EShMsgSpvRules) && program.mapIO();
    CHECK(linked, "shader of {}: {}", label, program.getInfoLog());
    glslang::SpvOptions options;
    options.disableOptimizer = true;
    SpirvWords words;
    glslang::GlslangToSpv(*program.getIntermediate(EShLangFragment), words, &options);
    return words;
}

// SPIRV-Tools unrolls only loops that ask for it; a driver's compiler unrolls what it can.
void ask_for_unrolling(SpirvWords& words) {
    for (std::size_t at = kHeaderWords; at < words.size();) {
        const std::uint32_t length = words[at] >> spv::WordCountShift;
        CHECK(length > 0, "word {}", at);
        if ((words[at] & spv::OpCodeMask) == spv::OpLoopMerge) words[at + 3] = spv::LoopControlUnrollMask;
        at += length;
    }
}

}  // namespace

SpirvWords compile_fragment_shader(const std::string& label, const std::string& glsl) {
    SpirvWords words = to_spirv(label, glsl);
    ask_for_unrolling(words);
    spvtools::Optimizer optimizer(SPV_ENV_UNIVERSAL_1_0);
    std::string log;
    optimizer.SetMessageConsumer(
        [&](spv_message_level_t level, const char*, const spv_position_t&, const char* message) {
            if (level <= SPV_MSG_ERROR) log = message;
        });
    optimizer.RegisterPerformancePasses();
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);  // glslang's output is taken as valid
    SpirvWords optimised;
    const bool done = optimizer.Run(words.data(), words.size(), &optimised, options);
    CHECK(done, "shader of {}: {}", label, log);
    return optimised;
}

std::string shader_compiler_version() {
    // "v2023.1" of "SPIRV-Tools v2023.1 unknown hash, ...".
    std::string_view tools = spvSoftwareVersionString();
    return fmt::format("glslang {}.{}.{}, SPIRV-Tools {}", GLSLANG_VERSION_MAJOR, GLSLANG_VERSION_MINOR,
                       GLSLANG_VERSION_PATCH, tools.substr(0, tools.find(' ')));
}

}  // namespace ropsim
