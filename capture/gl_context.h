// A headless OpenGL 4.5 core context, current on the thread that made it.
#pragma once

#include "base/crash_remark.h"

#include <memory>
#include <string>

namespace ropsim {

enum class GlPlatform {
    kAny,          // a real GPU where there is one, else whatever draws
    kDevice,       // EGL devices only (EGL_EXT_platform_device)
    kSurfaceless,  // Mesa's surfaceless platform only (llvmpipe where there is no GPU)
};

class GlContext {
 public:
    // Throws UserError, naming the packages to install, where no OpenGL 4.5 can be had.
    explicit GlContext(GlPlatform platform = platform_from_environment());
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    // The driver's name for what draws, e.g. "llvmpipe (LLVM 15.0.6, 256 bits)".
    const std::string& renderer() const;

    // ROPSIM_GL=surfaceless or device; unset or "any" is kAny, anything else a UserError.
    static GlPlatform platform_from_environment();

 private:
    struct State;
    CrashRemark remark_;  // drivers crash where they get no memory
    std::unique_ptr<State> state_;
};

}  // namespace ropsim
