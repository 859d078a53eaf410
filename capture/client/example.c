// A program of its own, in plain C, that draws a few transparent triangles and leaves a fragment trace:
// trace_client_example TRACE. Errors are handled as briefly as an example may.
#include "capture/client/ropsim_trace_client.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>

enum { kWidth = 64, kHeight = 48, kCapacity = 16384 };

// Triangles in pixels from the lower left and window depth: a haze over everything, twice, and glass before
// half of it.
static const char* const kVertex =
    "#version 450 core\n"
    "uniform vec3 u_corners[3];\n"
    "uniform float u_step;  // towards the eye, from one instance to the next\n"
    "flat out uint v_instance;\n"
    "void main() {\n"
    "    v_instance = uint(gl_InstanceID);\n"
    "    vec3 at = u_corners[gl_VertexID];\n"
    "    gl_Position = vec4(at.xy / vec2(32.0, 24.0) - 1.0, 2.0 * (at.z - u_step * float(v_instance)) - 1.0, "
    "1.0);\n"
    "}\n";
static const char* const kFragment =
    "flat in uint v_instance;\n"
    "uniform vec4 u_color;\n"
    "uniform uint u_draw;\n"
    "void main() { ropsim_append(u_color, u_draw, v_instance + uint(gl_PrimitiveID)); }\n";

static void fail(const char* why) {
    fprintf(stderr, "trace_client_example: %s\n", why);
    exit(1);
}

static void open_context(void) {
    EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, NULL, NULL);
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5, EGL_NONE};
    if (!eglInitialize(display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API)) fail("no OpenGL through EGL");
    EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) fail("no OpenGL 4.5");
}

// ROPSIM_APPEND_GLSL is the path of capture/client/ropsim_append.glsl.
static char* read_include(void) {
    static char text[8192];
    FILE* file = fopen(ROPSIM_APPEND_GLSL, "r");
    if (file == NULL) fail("cannot open " ROPSIM_APPEND_GLSL);
    text[fread(text, 1, sizeof text - 1, file)] = '\0';
    fclose(file);
    return text;
}

static void add_shader(GLuint program, GLenum stage, int count, const char* const* texts) {
    GLuint shader = glCreateShader(stage);
    GLint compiled = GL_FALSE;
    glShaderSource(shader, count, texts, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) fail("a shader does not compile");
    glAttachShader(program, shader);
}

static GLuint make_program(void) {
    GLuint program = glCreateProgram();
    const char* fragment[] = {"#version 450 core\n", read_include(), kFragment};
    add_shader(program, GL_VERTEX_SHADER, 1, &kVertex);
    add_shader(program, GL_FRAGMENT_SHADER, 3, fragment);
    glLinkProgram(program);
    glUseProgram(program);
    return program;
}

static void draw(GLuint program, GLuint number, const float corners[9], float step, const float color[4],
                 GLsizei instances) {
    glUniform3fv(glGetUniformLocation(program, "u_corners"), 3, corners);
    glUniform1f(glGetUniformLocation(program, "u_step"), step);
    glUniform4fv(glGetUniformLocation(program, "u_color"), 1, color);
    glUniform1ui(glGetUniformLocation(program, "u_draw"), number);
    glDrawArraysInstanced(GL_TRIANGLES, 0, 3, instances);
}

int main(int argc, char** argv) {
    if (argc != 2) fail("give the path of the trace to write");
    open_context();
    GLuint program = make_program();

    // 1. Nothing is drawn into, and nothing removes fragments: no depth test, no blending.
    GLuint target, array, buffer;
    glCreateFramebuffers(1, &target);
    glNamedFramebufferParameteri(target, GL_FRAMEBUFFER_DEFAULT_WIDTH, kWidth);
    glNamedFramebufferParameteri(target, GL_FRAMEBUFFER_DEFAULT_HEIGHT, kHeight);
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glViewport(0, 0, kWidth, kHeight);
    glCreateVertexArrays(1, &array);
    glBindVertexArray(array);

    // 2. A buffer for the records, empty: its first word counts.
    static uint32_t records[8 + 8 * kCapacity];
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, sizeof records, records, 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);

    // 3. What is drawn, told to the trace and to OpenGL.
    const RopsimTraceInfo info = {.width = kWidth,
                                  .height = kHeight,
                                  .bottom_up = 1,
                                  .background = {0.1f, 0.2f, 0.4f},
                                  .scene = "two layers of haze and a pane of glass"};
    const RopsimDraw haze = {.name = "haze",
                             .depth_test = 1,
                             .full = {8, 0, 0},
                             .alpha = {2, 0, 0},
                             .cost_source = "counted by hand"};
    const RopsimDraw glass = {.name = "glass", .depth_test = 1};
    RopsimTrace* trace = ropsim_trace_create(argv[1], &info);
    ropsim_trace_add_draw(trace, &haze, NULL);
    ropsim_trace_add_draw(trace, &glass, NULL);
    draw(program, 0, (const float[]){0, 0, 0.75f, 128, 0, 0.75f, 0, 96, 0.75f}, 0.5f,
         (const float[]){1, 1, 1, 0.25f}, 2);
    draw(program, 1, (const float[]){8, 8, 0.5f, 40.5f, 8, 0.5f, 8, 40.5f, 0.5f}, 0,
         (const float[]){0, 1, 0, 0.5f}, 1);

    // 4. Read back once the GPU has written, and hand over. An error is kept and every later call fails with
    // it.
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffer, 0, sizeof records, records);
    ropsim_trace_append_records(trace, records, sizeof records);
    if (ropsim_trace_finish(trace) != 0) fail(ropsim_trace_error(trace));
    ropsim_trace_free(trace);
    return 0;
}
