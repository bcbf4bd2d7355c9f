#pragma once

#include <pybind11/pybind11.h>

#include <exception>

namespace regraft::bindings {

/// Lets Python have a word while a thread that called from it works without the GIL: signal
/// handlers first, so that Ctrl-C ends the work, then `body`. The first exception is kept, ends
/// the work, and is rethrown when the GIL is held again.
class PythonPoll {
 public:
  /// Called without the GIL. @return false to end the work.
  template <typename Body>
  bool operator()(const Body& body) {
    const pybind11::gil_scoped_acquire gil;
    try {
      if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
      return body();
    } catch (...) {
      error_ = std::current_exception();
      return false;
    }
  }

  /// Called with the GIL.
  void rethrow() {
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

 private:
  std::exception_ptr error_;
};

}  // namespace regraft::bindings
