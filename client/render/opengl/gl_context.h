#pragma once

#include <string>

#include <glm/glm.hpp>

#include "pointreel/error.h"

struct GLFWwindow;

namespace pointreel {

/// Describes the OpenGL of the current context: "OpenGL 4.5 (Core Profile) Mesa 22.3.6 on llvmpipe
/// (...)".
std::string describe_opengl();

/// Whether the processor does the work of the current context, because there is no graphics card or
/// no driver for it.
bool is_software_opengl();

/// An OpenGL 4.5 core context without a window or a display. EGL makes it on the first device that
/// can, otherwise on Mesa's surfaceless platform. It has no default framebuffer.
class OffscreenContext {
 public:
  /// Creates the context and makes it current on the calling thread, where it must stay. Fails with
  /// ErrorCode::unsupported; the message says which OpenGL was found instead.
  static Result<OffscreenContext> create();

  OffscreenContext(OffscreenContext&& other) noexcept;
  OffscreenContext& operator=(OffscreenContext&& other) noexcept;
  ~OffscreenContext();

 private:
  OffscreenContext(void* display, void* context) : display_(display), context_(context) {}

  void* display_ = nullptr;  ///< EGLDisplay; the whole process shares it, so it is not terminated
  void* context_ = nullptr;  ///< EGLContext
};

/// A GLFW window with an OpenGL 4.5 core context. A process may have one at a time, on its main
/// thread.
class WindowContext {
 public:
  /// Opens the window and makes its context current. Pictures change with the refresh of the
  /// display. Fails with ErrorCode::unsupported; the message says whether the display is missing or
  /// its OpenGL is too old.
  static Result<WindowContext> create(const std::string& title, int width, int height);

  /// Opens a window with any version of OpenGL. If create() has failed, that is enough to show a
  /// message.
  static Result<WindowContext> create_of_any_version(const std::string& title, int width,
                                                     int height);

  WindowContext(WindowContext&& other) noexcept;
  WindowContext& operator=(WindowContext&& other) noexcept;
  ~WindowContext();

  /// For input and its callbacks. This object keeps ownership of the window.
  GLFWwindow* handle() const { return window_; }

  /// Fills the window's framebuffer with an sRGB colour.
  void clear(const glm::vec3& color);
  /// Waits until all submitted commands are complete.
  void finish();
  /// Shows the contents of the window's framebuffer.
  void swap();

 private:
  explicit WindowContext(GLFWwindow* window) : window_(window) {}

  GLFWwindow* window_ = nullptr;
};

}  // namespace pointreel
