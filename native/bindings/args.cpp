#include "args.h"

#include <algorithm>

namespace regraft::bindings {

namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw py::value_error(message);
}

std::string type_name(const py::object& object) {
  return py::type::handle_of(object).attr("__name__").cast<std::string>();
}

std::string text(const py::handle& object) {
  return py::str(object).cast<std::string>();
}

std::string text(const std::vector<py::dtype>& dtypes) {
  std::string names;
  for (const py::dtype& dtype : dtypes) names += (names.empty() ? "" : " or ") + text(dtype);
  return names;
}

/// A shape as NumPy writes it, N standing for -1.
std::string text(const Shape& shape) {
  std::string lengths;
  for (std::size_t i = 0; i < shape.size(); ++i) {
    lengths += (i == 0 ? "" : ", ") + (shape[i] < 0 ? "N" : std::to_string(shape[i]));
  }
  return "(" + lengths + (shape.size() == 1 ? ",)" : ")");
}

bool fits(const Shape& shape, const Shape& wanted) {
  const auto same = [](py::ssize_t got, py::ssize_t want) { return want < 0 || got == want; };
  return std::equal(shape.begin(), shape.end(), wanted.begin(), wanted.end(), same);
}

}  // namespace

py::array checked_array(const py::object& object, const std::string& name,
                        const std::vector<py::dtype>& dtypes, const Shape& shape) {
  if (!py::isinstance<py::array>(object)) {
    refuse(name + ": a NumPy array of " + text(dtypes) + " wanted, got " + type_name(object));
  }
  auto array = py::reinterpret_borrow<py::array>(object);
  const auto is_dtype = [&](const py::dtype& d) { return array.dtype().equal(d); };
  if (std::none_of(dtypes.begin(), dtypes.end(), is_dtype)) {
    refuse(name + ": " + text(dtypes) + " wanted, got " + text(array.dtype()) +
           "; convert it with .astype(\"" + text(dtypes.front()) + "\")");
  }
  const Shape got(array.shape(), array.shape() + array.ndim());
  if (!fits(got, shape)) refuse(name + ": shape " + text(shape) + " wanted, got " + text(got));
  return array;
}

std::int64_t checked_int(const py::object& object, const std::string& name, std::int64_t low,
                         std::int64_t high) {
  if (!PyIndex_Check(object.ptr())) {
    refuse(name + ": a whole number wanted, got " + type_name(object));
  }
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(object.ptr()));
  if (!number) throw py::error_already_set();
  int overflow = 0;
  const long long value = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  if (overflow != 0 || value < low || value > high) {
    refuse(name + ": " + text(number) + " is outside [" + std::to_string(low) + ", " +
           std::to_string(high) + "]");
  }
  return value;
}

std::uint32_t checked_id(const py::object& object, const std::string& name) {
  return static_cast<std::uint32_t>(checked_int(object, name, 0, 0xFFFFFFFE));
}

std::vector<std::uint32_t> checked_ids(const py::object& object, const std::string& name) {
  if (py::isinstance<py::array>(object)) {
    const auto array = checked<std::uint32_t>(object, name, {-1});
    return {array.data(), array.data() + array.size()};
  }
  if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object)) {
    refuse(name + ": an array of uint32 or a sequence of ints wanted, got " + type_name(object));
  }
  std::vector<std::uint32_t> ids;
  for (const py::handle item : object) {
    ids.push_back(checked_id(py::reinterpret_borrow<py::object>(item), name));
  }
  return ids;
}

double checked_number(const py::object& object, const std::string& name) {
  const double value = PyFloat_AsDouble(object.ptr());
  if (value != -1.0 || PyErr_Occurred() == nullptr) return value;
  PyErr_Clear();
  refuse(name + ": a number wanted, got " + type_name(object));
}

void checked_numbers(const py::object& object, const std::string& name, std::span<double> out) {
  const std::string wanted = name + ": " + std::to_string(out.size()) + " numbers wanted, got ";
  if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object)) {
    refuse(wanted + type_name(object));
  }
  const std::size_t count = py::len(object);
  if (count != out.size()) refuse(wanted + std::to_string(count));
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = checked_number(py::object(object[py::int_(i)]), name);
  }
}

Mat4d checked_matrix(const py::object& object, const std::string& name) {
  return matrix_from_rows(checked<double>(object, name, {4, 4}).data());
}

Mat4d matrix_from_rows(const double* rows) {
  Mat4d m;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) m[column][row] = rows[4 * row + column];
  }
  return m;
}

}  // namespace regraft::bindings
