#pragma once

#include <string>

#include <glm/glm.hpp>

#include "pointreel/error.h"

struct GLFWwindow;

namespace pointreel {

/// The OpenGL that a context has: "OpenGL 4.5 (Core Profile) Mesa 22.3.6 on llvmpipe (...)". A
/// context must be current.
std::string describe_opengl();

/// An OpenGL 4.5 core context without any window or display: by EGL, on the first device that has
/// one, else on Mesa's surfaceless platform. It has no default framebuffer.
class OffscreenContext {
 public:
  /// Creates the context and makes it current on the calling thread, where it must stay. The error
  /// says what was found instead.
  static Result<OffscreenContext> create();

  OffscreenContext(OffscreenContext&& other) noexcept;
  OffscreenContext& operator=(OffscreenContext&& other) noexcept;
  ~OffscreenContext();

 private:
  OffscreenContext(void* display, void* context) : display_(display), context_(context) {}

  void* display_ = nullptr;  ///< EGLDisplay; shared by the process, so it is never terminated
  void* context_ = nullptr;  ///< EGLContext
};

/// A window with an OpenGL 4.5 core context, by GLFW. One at a time in a process, on the main
/// thread.
class WindowContext {
 public:
  /// Opens the window and makes its context current; the picture changes with the display's
  /// refresh. The error says whether there is no display or not enough OpenGL.
  static Result<WindowContext> create(const std::string& title, int width, int height);

  /// With whatever OpenGL there is: enough for a few words, where create() has failed.
  static Result<WindowContext> create_of_any_version(const std::string& title, int width,
                                                     int height);

  WindowContext(WindowContext&& other) noexcept;
  WindowContext& operator=(WindowContext&& other) noexcept;
  ~WindowContext();

  /// For input and its callbacks; the window stays this object's.
  GLFWwindow* handle() const { return window_; }
  /// Of what is written in the window, by the display: 1 for 96 pixels an inch.
  float content_scale() const;

  /// Fills framebuffer 0 with an sRGB colour.
  void clear(const glm::vec3& color);
  /// Waits until everything has been drawn.
  void finish();
  /// Shows what was drawn into framebuffer 0.
  void swap();

 private:
  explicit WindowContext(GLFWwindow* window) : window_(window) {}

  GLFWwindow* window_ = nullptr;
};

}  // namespace pointreel
