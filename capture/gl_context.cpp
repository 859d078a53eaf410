// Finds an EGL display that gives an OpenGL 4.5 core context without a window, real GPUs first.
#include "capture/gl_context.h"

#include "base/error.h"

#include <cstdlib>
#include <string_view>
#include <vector>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

namespace ropsim {

struct GlContext::State {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    std::string renderer;

    State() = default;
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    ~State() {
        if (display == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
        // No eglTerminate: the display belongs to the process and may carry other contexts.
        eglReleaseThread();
    }
};

namespace {

constexpr int kMaxDevices = 32;
constexpr const char* kRemedy =
    "install Debian's libegl1, libgl1 and libgl1-mesa-dri (llvmpipe draws without a GPU), or a GPU driver "
    "with EGL";

constexpr const char* kCrash =
    "OpenGL: the driver crashed, and nothing was written; give it more memory, draw fewer fragments or a "
    "smaller "
    "image, or choose another driver with ROPSIM_GL (any, device, surfaceless)";

bool software(std::string_view renderer) {
    for (std::string_view name : {"llvmpipe", "softpipe", "swrast", "SWR", "lavapipe"}) {
        if (renderer.find(name) != std::string_view::npos) return true;
    }
    return false;
}

}  // namespace

GlPlatform GlContext::platform_from_environment() {
    const char* text = std::getenv("ROPSIM_GL");
    const std::string_view name = text == nullptr ? "" : text;
    if (name.empty() || name == "any") return GlPlatform::kAny;
    if (name == "device") return GlPlatform::kDevice;
    if (name == "surfaceless") return GlPlatform::kSurfaceless;
    throw UserError("ROPSIM_GL", fmt::format("'{}' is not a platform; use any, device or surfaceless", name));
}

const std::string& GlContext::renderer() const {
    return state_->renderer;
}

GlContext::~GlContext() = default;

namespace {

// Why the last display tried gave no context; the most telling reason wins the error message.
struct Attempt {
    std::string reason = "no EGL display";
};

// Makes a 4.5 core context of `display` current in `state`; false with a reason where it cannot.
template <typename State>
bool open_display(EGLDisplay display, State& state, Attempt& attempt) {
    EGLint major = 0;
    EGLint minor = 0;
    if (display == EGL_NO_DISPLAY || eglInitialize(display, &major, &minor) != EGL_TRUE) return false;
    state.display = display;
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) {
        attempt.reason = "EGL has no desktop OpenGL";
        return false;
    }
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint configs = 0;
    if (eglChooseConfig(display, config_attributes, &config, 1, &configs) != EGL_TRUE || configs == 0) {
        config = EGL_NO_CONFIG_KHR;
    }
    const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                         4,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         5,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
    state.context = eglCreateContext(display, config, EGL_NO_CONTEXT, context_attributes);
    if (state.context == EGL_NO_CONTEXT) {
        attempt.reason = "the driver has no OpenGL 4.5 core";
        return false;
    }
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, state.context) != EGL_TRUE) {
        attempt.reason = "the driver cannot draw without a window (EGL_KHR_surfaceless_context)";
        return false;
    }
    const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    state.renderer = name == nullptr ? "unknown" : name;
    return true;
}

}  // namespace

GlContext::GlContext(GlPlatform platform) : remark_(kCrash) {
    if (!epoxy_has_egl()) throw UserError("OpenGL", fmt::format("libEGL is missing; {}", kRemedy));
    Attempt attempt;
    // Candidates in order of preference: hardware devices, the surfaceless platform, software devices.
    const auto try_display = [&](EGLDisplay display, bool take_software) {
        auto state = std::make_unique<State>();
        if (!open_display(display, *state, attempt)) return false;
        if (!take_software && software(state->renderer)) return false;
        state_ = std::move(state);
        return true;
    };
    std::vector<EGLDeviceEXT> devices;
    if (platform != GlPlatform::kSurfaceless &&
        epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") &&
        epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base")) {
        devices.resize(kMaxDevices);
        EGLint count = 0;
        if (eglQueryDevicesEXT(kMaxDevices, devices.data(), &count) != EGL_TRUE) count = 0;
        devices.resize(static_cast<std::size_t>(count));
    }
    for (EGLDeviceEXT device : devices) {
        if (try_display(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr), false)) return;
    }
    if (platform != GlPlatform::kDevice &&
        epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless") &&
        try_display(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr), true)) {
        return;
    }
    for (EGLDeviceEXT device : devices) {
        if (try_display(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr), true)) return;
    }
    throw UserError("OpenGL", fmt::format("no headless OpenGL 4.5 ({}); {}", attempt.reason, kRemedy));
}

}  // namespace ropsim
