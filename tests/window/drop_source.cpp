#include "tests/window/drop_source.h"

#include <chrono>
#include <optional>
#include <string_view>
#include <utility>

#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <fmt/format.h>
#include <poll.h>

namespace pointreel::window {
namespace {

using std::chrono::steady_clock;

constexpr long kVersion = 5;

/// A single drag. See https://www.freedesktop.org/wiki/Specifications/XDND
class Drag {
 public:
  Drag(Display* display, Window target, std::string list)
      : display_(display),
        target_(target),
        list_(std::move(list)),
        source_(XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0)) {
    XSetSelectionOwner(display_, atom("XdndSelection"), source_, CurrentTime);
  }
  ~Drag() {
    XDestroyWindow(display_, source_);
    XSync(display_, False);
  }
  Drag(const Drag&) = delete;
  Drag& operator=(const Drag&) = delete;

  bool run() {
    if (!aware()) return false;
    XWindowAttributes place{};
    XGetWindowAttributes(display_, target_, &place);
    int x = 0, y = 0;
    Window child = 0;
    XTranslateCoordinates(display_, target_, place.root, place.width / 2, place.height / 2, &x, &y,
                          &child);
    send("XdndEnter", kVersion << 24, static_cast<long>(atom("text/uri-list")));
    send("XdndPosition", 0, x << 16 | y, CurrentTime, static_cast<long>(atom("XdndActionCopy")));
    const auto status = answer("XdndStatus");
    if (!status || (status->data.l[1] & 1) == 0) return false;
    send("XdndDrop", 0, CurrentTime);
    return answer("XdndFinished").has_value();
  }

 private:
  Atom atom(const char* name) const { return XInternAtom(display_, name, False); }

  bool aware() const {
    Atom type = 0;
    int format = 0;
    unsigned long count = 0, left = 0;
    unsigned char* data = nullptr;
    XGetWindowProperty(display_, target_, atom("XdndAware"), 0, 1, False, AnyPropertyType, &type,
                       &format, &count, &left, &data);
    if (data != nullptr) XFree(data);
    return count == 1;
  }

  void send(const char* message, long l1, long l2, long l3 = 0, long l4 = 0) const {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.display = display_;
    event.xclient.window = target_;
    event.xclient.message_type = atom(message);
    event.xclient.format = 32;
    const long data[5] = {static_cast<long>(source_), l1, l2, l3, l4};
    for (int i = 0; i < 5; ++i) event.xclient.data.l[i] = data[i];
    XSendEvent(display_, target_, False, NoEventMask, &event);
    XFlush(display_);
  }

  /// Sends the list to any client that requests it, until this message arrives.
  std::optional<XClientMessageEvent> answer(const char* message) const {
    const Atom wanted = atom(message);
    const auto deadline = steady_clock::now() + std::chrono::seconds(60);
    while (steady_clock::now() < deadline) {
      while (XPending(display_) > 0) {
        XEvent event;
        XNextEvent(display_, &event);
        if (event.type == SelectionRequest) give(event.xselectionrequest);
        if (event.type == ClientMessage && event.xclient.message_type == wanted)
          return event.xclient;
      }
      pollfd waiting{ConnectionNumber(display_), POLLIN, 0};
      ::poll(&waiting, 1, 100);
    }
    return std::nullopt;
  }

  void give(const XSelectionRequestEvent& request) const {
    XChangeProperty(display_, request.requestor, request.property, request.target, 8,
                    PropModeReplace, reinterpret_cast<const unsigned char*>(list_.data()),
                    static_cast<int>(list_.size()));
    XEvent event{};
    event.xselection.type = SelectionNotify;
    event.xselection.requestor = request.requestor;
    event.xselection.selection = request.selection;
    event.xselection.target = request.target;
    event.xselection.property = request.property;
    event.xselection.time = request.time;
    XSendEvent(display_, request.requestor, False, NoEventMask, &event);
    XFlush(display_);
  }

  Display* const display_;
  const Window target_;
  const std::string list_;
  const Window source_;
};

}  // namespace

std::string uri_list(const std::vector<std::filesystem::path>& files) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789/-_.~";
  std::string list;
  for (const auto& file : files) {
    list += "file://";
    for (const char c : file.string())
      list += kPlain.find(c) != std::string_view::npos
                  ? std::string(1, c)
                  : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    list += "\r\n";
  }
  return list;
}

bool drop_files(Display* display, unsigned long window,
                const std::vector<std::filesystem::path>& files) {
  return Drag(display, window, uri_list(files)).run();
}

}  // namespace pointreel::window
