#include "client/bindings/python/call.h"

#include <cstring>
#include <string>
#include <utility>

#include "common/base/hide_secrets.h"
#include "common/process/print.h"

namespace py = pybind11;

namespace pointreel {
namespace {

/// The class, which lives as long as the interpreter.
PyObject* error_class = nullptr;

}  // namespace

std::string for_python(const std::string& line) {
  std::string text = visible(hide_secrets(line));
  constexpr std::pair<const char*, const char*> kNames[] = {
      {"--frame-memory, in programs max_memory,", "max_memory"},
      {"--frame-memory", "max_memory"},
      {"--token", "token"},
      {"--ca-file", "ca_file"},
      {"--best-effort", "best_effort=True"},
      {"--force", "replace=True"},
      {"--bitrate", "bitrate"},
      {"--codec octree", "codec=\"octree\""},
      {"--codec video", "codec=\"video\""},
      {"--columns", "columns"},
      {"--cube frame", "cube=\"frame\""},
      {"--color-max", "color_max"},
      {"--topic", "topic"},
      {"--scalar-step", "scalar_steps"},
      {"--scale", "scale"},
      {"--segment", "segment"},
      {"--voxel", "voxel"},
      {"--rotate", "rotate"},
      {"--fps", "fps"}};
  for (const auto& [option, argument] : kNames) {
    for (std::size_t at = 0; (at = text.find(option, at)) != std::string::npos;)
      text.replace(at, std::strlen(option), argument);
  }
  return text;
}

void add_error(py::module_& module) {
  error_class = PyErr_NewExceptionWithDoc("pointreel.Error",
                                          "What went wrong, in one line. `code` is invalid, "
                                          "unsupported, limit, argument, not_found, io, "
                                          "cancelled or refused.",
                                          nullptr, nullptr);
  if (error_class == nullptr) throw py::error_already_set();
  module.attr("Error") = py::handle(error_class);
}

void raise(const Error& error) {
  py::object exception = py::handle(error_class)(for_python(error.message));
  exception.attr("code") = name(error.code);
  PyErr_SetObject(error_class, exception.ptr());
  throw py::error_already_set();
}

}  // namespace pointreel
