#pragma once
#include <nanobind/nanobind.h>

#include <chrono>
#include <functional>
#include <utility>

namespace mimbre::python {

/// Lets Python have its say now and then while the library computes without the interpreter's lock: signals
/// (Ctrl-C) and a progress report. What it raises stops the computation and is kept. Made and destroyed with
/// the lock.
class Attention {
 public:
  explicit Attention(std::function<void()> report = {}) : report_(std::move(report)) {}

  /// Whether to stop. Asks Python at most twenty times a second.
  bool stop() {
    if (raised_.is_valid()) return true;
    const auto now = std::chrono::steady_clock::now();
    if (now < due_) return false;
    due_ = now + std::chrono::milliseconds(50);
    call([&] {
      if (PyErr_CheckSignals() != 0) nanobind::raise_python_error();
      if (report_) report_();
    });
    return raised_.is_valid();
  }

  /// Calls what needs the interpreter; what it raises is kept.
  template <class Function>
  void call(const Function& function) {
    const nanobind::gil_scoped_acquire locked;
    try {
      function();
    } catch (nanobind::python_error& error) {
      keep(error);
    }
  }

  /// Keeps what Python raised.
  void keep(nanobind::python_error& error) {
    const nanobind::gil_scoped_acquire locked;
    error.restore();
    PyObject *type = nullptr, *value = nullptr, *trace = nullptr;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    if (trace) PyException_SetTraceback(value, trace);
    raised_ = nanobind::steal(value);
    Py_XDECREF(type);
    Py_XDECREF(trace);
  }

  /// Raises what Python raised. Needs the interpreter's lock.
  void raise() const {
    if (!raised_.is_valid()) return;
    PyErr_SetObject(raised_.type().ptr(), raised_.ptr());
    nanobind::raise_python_error();
  }
  /// What Python raised; None otherwise. Needs the interpreter's lock.
  nanobind::object raised() const { return raised_.is_valid() ? raised_ : nanobind::none(); }

 private:
  std::function<void()> report_;
  std::chrono::steady_clock::time_point due_ =
      std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
  nanobind::object raised_;
};

}  // namespace mimbre::python
