#pragma once

#include <filesystem>
#include <string>
#include <vector>

struct _XDisplay;

namespace pointreel::window {

/// Drags files over the middle of a window and drops them there, as a file manager does: the
/// source's side of XDND, version 5. Returns false if the window does not accept them within ten
/// seconds.
bool drop_files(_XDisplay* display, unsigned long window,
                const std::vector<std::filesystem::path>& files);

/// The list "file:///a%20folder\r\n" in the MIME type text/uri-list of RFC 2483.
std::string uri_list(const std::vector<std::filesystem::path>& files);

}  // namespace pointreel::window
