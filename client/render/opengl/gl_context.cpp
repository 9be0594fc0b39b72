#include "client/render/opengl/gl_context.h"

#include <array>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace pointreel {
namespace {

const char* text(const GLubyte* s) {
  return s ? reinterpret_cast<const char*>(s) : "an unknown renderer";
}

bool can_load(const char* library) {
  void* loaded = dlopen(library, RTLD_LAZY | RTLD_LOCAL);
  if (loaded) dlclose(loaded);
  return loaded != nullptr;
}

bool has_extension(const char* list, const char* name) {
  const std::size_t length = std::strlen(name);
  for (const char* at = list; at && (at = std::strstr(at, name)) != nullptr; at += length) {
    if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
  }
  return false;
}

/// All EGL displays that need no screen. Devices come first because they may be hardware.
std::vector<EGLDisplay> screenless_displays() {
  std::vector<EGLDisplay> displays;
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (has_extension(client, "EGL_EXT_platform_device") &&
      (has_extension(client, "EGL_EXT_device_enumeration") ||
       has_extension(client, "EGL_EXT_device_base"))) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count);
    for (EGLint i = 0; i < count; ++i) {
      displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                                  devices[static_cast<std::size_t>(i)], nullptr));
    }
  }
  if (has_extension(client, "EGL_MESA_platform_surfaceless")) {
    displays.push_back(
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  return displays;
}

EGLContext current_context(EGLDisplay display, bool newest) {
  const std::array<EGLint, 7> wanted = {EGL_CONTEXT_MAJOR_VERSION,
                                        4,
                                        EGL_CONTEXT_MINOR_VERSION,
                                        5,
                                        EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                        EGL_NONE};
  const EGLint any = EGL_NONE;
  EGLContext context =
      eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, newest ? wanted.data() : &any);
  if (context == EGL_NO_CONTEXT) return context;
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    eglDestroyContext(display, context);
    return EGL_NO_CONTEXT;
  }
  return context;
}

void destroy_current(EGLDisplay display, EGLContext context) {
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display, context);
}

std::string glfw_error() {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return reason ? reason : "no reason given";
}

tl::unexpected<Error> cannot_open() {
  return fail(ErrorCode::unsupported, "cannot open a window: " + glfw_error());
}

/// Xlib ends the program on errors such as a drag whose window has gone before GLFW answers it.
/// There is nothing to do about them. Does nothing where GLFW has not loaded Xlib.
void outlive_x_errors() {
  void* const xlib = dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
  if (xlib == nullptr) return;
  using Handler = int (*)(void* display, void* error);
  using SetHandler = Handler (*)(Handler);
  if (void* const set = dlsym(xlib, "XSetErrorHandler"))
    reinterpret_cast<SetHandler>(set)([](void*, void*) { return 0; });
  dlclose(xlib);
}

}  // namespace

std::string describe_opengl() {
  return std::string("OpenGL ") + text(glGetString(GL_VERSION)) + " on " +
         text(glGetString(GL_RENDERER));
}

bool is_software_opengl() {
  const std::string_view renderer = text(glGetString(GL_RENDERER));
  for (const std::string_view name : {"llvmpipe", "softpipe", "SwiftShader", "Software"})
    if (renderer.find(name) != std::string_view::npos) return true;
  return false;
}

Result<OffscreenContext> OffscreenContext::create() {
  // Where a library is missing, epoxy would end the process.
  if (!can_load("libEGL.so.1") || !(can_load("libOpenGL.so.0") || can_load("libGL.so.1")))
    return fail(ErrorCode::unsupported, "the OpenGL libraries libEGL and libGL are not installed");
  std::string found;
  for (EGLDisplay display : screenless_displays()) {
    EGLint major = 0, minor = 0;
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) continue;
    if (!eglBindAPI(EGL_OPENGL_API)) continue;
    if (EGLContext context = current_context(display, true); context != EGL_NO_CONTEXT) {
      if (epoxy_is_desktop_gl() && epoxy_gl_version() >= 45) {
        return OffscreenContext(display, context);
      }
      found = describe_opengl();
      destroy_current(display, context);
    } else if (context = current_context(display, false); context != EGL_NO_CONTEXT) {
      found = describe_opengl();
      destroy_current(display, context);
    }
  }
  return fail(ErrorCode::unsupported,
              "OpenGL 4.5 is needed to draw, but EGL offers " +
                  (found.empty() ? std::string("no OpenGL at all") : "only " + found) +
                  "; install a graphics driver, or libgl1-mesa-dri for software rendering");
}

OffscreenContext::OffscreenContext(OffscreenContext&& other) noexcept
    : display_(std::exchange(other.display_, nullptr)),
      context_(std::exchange(other.context_, nullptr)) {}

OffscreenContext& OffscreenContext::operator=(OffscreenContext&& other) noexcept {
  std::swap(display_, other.display_);
  std::swap(context_, other.context_);
  return *this;
}

OffscreenContext::~OffscreenContext() {
  if (!context_) return;
  // Another context may have become current since, and must stay so.
  if (eglGetCurrentContext() == context_) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display_, context_);
}

Result<WindowContext> WindowContext::create(const std::string& title, int width, int height) {
  if (!glfwInit()) return cannot_open();
  outlive_x_errors();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  // On X11, EGL comes first: Mesa's EGL loads in half the time of its GLX.
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window) {
    glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_NATIVE_CONTEXT_API);
    window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  }
  if (!window) {
    std::string reason = "cannot open a window with OpenGL 4.5: " + glfw_error();
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    if (GLFWwindow* any = glfwCreateWindow(1, 1, "", nullptr, nullptr)) {
      glfwMakeContextCurrent(any);
      reason += "; this display has " + describe_opengl();
      glfwDestroyWindow(any);
    }
    glfwTerminate();
    return fail(ErrorCode::unsupported, std::move(reason));
  }
  glfwMakeContextCurrent(window);
  glfwSwapInterval(1);
  return WindowContext(window);
}

Result<WindowContext> WindowContext::create_of_any_version(const std::string& title, int width,
                                                           int height) {
  if (!glfwInit()) return cannot_open();
  outlive_x_errors();
  glfwDefaultWindowHints();
  GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window) {
    auto failure = cannot_open();  // GLFW forgets the reason when it ends
    glfwTerminate();
    return failure;
  }
  glfwMakeContextCurrent(window);
  return WindowContext(window);
}

WindowContext::WindowContext(WindowContext&& other) noexcept
    : window_(std::exchange(other.window_, nullptr)) {}

WindowContext& WindowContext::operator=(WindowContext&& other) noexcept {
  std::swap(window_, other.window_);
  return *this;
}

WindowContext::~WindowContext() {
  if (!window_) return;
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void WindowContext::clear(const glm::vec3& color) {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_SCISSOR_TEST);
  glClearColor(color.x, color.y, color.z, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
}

void WindowContext::finish() { glFinish(); }

void WindowContext::swap() { glfwSwapBuffers(window_); }

}  // namespace pointreel
