#include "client/bindings/python/call.h"

#include "common/process/print.h"

namespace py = pybind11;

namespace pointreel {
namespace {

/// The class, which lives as long as the interpreter.
PyObject* error_class = nullptr;

}  // namespace

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
  py::object exception = py::handle(error_class)(visible(error.message));
  exception.attr("code") = name(error.code);
  PyErr_SetObject(error_class, exception.ptr());
  throw py::error_already_set();
}

}  // namespace pointreel
