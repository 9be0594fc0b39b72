#include "tests/window/virtual_display.h"

#include <cstdlib>
#include <sstream>
#include <string_view>

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <fmt/format.h>
#include <unistd.h>

#include "tests/e2e/process.h"
#include "tests/window/drop_source.h"

namespace pointreel::window {
namespace {

/// Returns the path of a program on PATH, or an empty string if there is none.
std::string find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string program = folder + "/" + name;
    if (folder.starts_with('/') && ::access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

/// Windows may vanish while they are examined. Xlib would end the test then, which is not wanted.
int ignore_error(Display*, XErrorEvent*) { return 0; }

}  // namespace

struct VirtualDisplay::Server {
  // It ends when the last connected program ends, so it cannot outlive a test.
  Server(const std::string& program, glm::ivec2 size)
      : process(program,
                {"-displayfd", "1", "-screen", "0", fmt::format("{}x{}x24", size.x, size.y),
                 "-nolisten", "tcp", "-terminate"}) {}
  ~Server() {
    if (display != nullptr) XCloseDisplay(display);
  }

  e2e::Background process;
  std::string name;
  Display* display = nullptr;
};

std::string VirtualDisplay::missing() {
  if (find_program("Xvfb").empty()) return "xvfb";
  if (find_program("xdotool").empty()) return "xdotool";
  return {};
}

Result<std::unique_ptr<VirtualDisplay>> VirtualDisplay::start(glm::ivec2 size) {
  if (const std::string lacks = missing(); !lacks.empty())
    return fail(fmt::format("{} is not installed: apt-get install {}", lacks, lacks));
  auto server = std::make_unique<Server>(find_program("Xvfb"), size);
  server->name = fmt::format(":{}", server->process.first_line());
  if (server->name == ":") return fail("Xvfb did not say which display it has");
  server->display = XOpenDisplay(server->name.c_str());
  if (server->display == nullptr) return fail("Xvfb does not answer on " + server->name);
  XSetErrorHandler(ignore_error);
  return std::unique_ptr<VirtualDisplay>(new VirtualDisplay(std::move(server)));
}

VirtualDisplay::VirtualDisplay(std::unique_ptr<Server> server) : server_(std::move(server)) {}
VirtualDisplay::~VirtualDisplay() = default;

const std::string& VirtualDisplay::name() const { return server_->name; }

WindowId VirtualDisplay::window() const {
  Window root = 0, parent = 0, *children = nullptr;
  unsigned count = 0;
  if (XQueryTree(server_->display, DefaultRootWindow(server_->display), &root, &parent, &children,
                 &count) == 0)
    return 0;
  Window found = 0;
  for (unsigned i = 0; i < count; ++i) {
    XWindowAttributes attributes{};
    if (XGetWindowAttributes(server_->display, children[i], &attributes) != 0 &&
        attributes.map_state == IsViewable && attributes.c_class == InputOutput &&
        attributes.width > 16)
      found = children[i];
  }
  if (children != nullptr) XFree(children);
  return found;
}

std::string VirtualDisplay::title(WindowId window) const {
  Atom type = 0;
  int format = 0;
  unsigned long count = 0, left = 0;
  unsigned char* data = nullptr;
  XGetWindowProperty(server_->display, window, XInternAtom(server_->display, "_NET_WM_NAME", False),
                     0, 1024, False, AnyPropertyType, &type, &format, &count, &left, &data);
  std::string title;
  if (data != nullptr) {
    if (format == 8) title.assign(reinterpret_cast<const char*>(data), count);
    XFree(data);
  }
  return title;
}

glm::ivec2 VirtualDisplay::size(WindowId window) const {
  XWindowAttributes attributes{};
  if (XGetWindowAttributes(server_->display, window, &attributes) == 0) return glm::ivec2(0);
  return {attributes.width, attributes.height};
}

e2e::Picture VirtualDisplay::picture(WindowId window) const {
  const glm::ivec2 extent = size(window);
  if (extent.x <= 0) return {};
  XImage* image = XGetImage(server_->display, window, 0, 0, static_cast<unsigned>(extent.x),
                            static_cast<unsigned>(extent.y), AllPlanes, ZPixmap);
  if (image == nullptr) return {};
  e2e::Picture picture;
  // The format of Xvfb on the machines that the tests run on: four bytes per pixel, blue first.
  if (image->bits_per_pixel == 32 && image->byte_order == LSBFirst) {
    picture.size = extent;
    picture.pixels.reserve(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y));
    for (int y = 0; y < extent.y; ++y) {
      const auto* row = reinterpret_cast<const unsigned char*>(image->data) +
                        static_cast<std::ptrdiff_t>(y) * image->bytes_per_line;
      for (int x = 0; x < extent.x; ++x, row += 4)
        picture.pixels.emplace_back(row[2], row[1], row[0]);
    }
  }
  XDestroyImage(image);
  return picture;
}

void VirtualDisplay::close(WindowId window) const {
  Display* display = server_->display;
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = window;
  event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
  event.xclient.data.l[1] = CurrentTime;
  XSendEvent(display, window, False, NoEventMask, &event);
  XSync(display, False);
}

void VirtualDisplay::xdotool(const std::vector<std::string>& commands) const {
  e2e::Background(find_program("xdotool"), commands, {{"DISPLAY=" + server_->name}, {}, {}}).end(0);
}

bool VirtualDisplay::drop(WindowId window, const std::vector<std::filesystem::path>& files) const {
  return drop_files(server_->display, window, files);
}

}  // namespace pointreel::window
