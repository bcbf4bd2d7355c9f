#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "regraft/core/vec.h"

namespace regraft::bindings {

namespace py = pybind11;

template <std::size_t N>
struct TypeText {
  char text[N]{};
  consteval TypeText(const char (&source)[N]) {
    for (std::size_t i = 0; i < N; ++i) text[i] = source[i];
  }
};

/// An argument taken as it comes; `type` is what signatures and stubs promise. It is checked by
/// the functions below, with ValueErrors that say what is wrong with which argument: pybind11's
/// own conversion would copy other dtypes silently and list overloads on failure.
template <TypeText type>
class Arg : public py::object {
 public:
  using py::object::object;
  static bool check_(py::handle) { return true; }
};

/// An object under another promise, for results.
template <typename Promised>
Promised as(const py::object& object) {
  return py::reinterpret_borrow<Promised>(object);
}

using IntArg = Arg<"typing.SupportsIndex">;
using FloatsArg = Arg<"numpy.typing.ArrayLike">;
using Float32Arg = Arg<"numpy.typing.NDArray[numpy.float32]">;
using Float64Arg = Arg<"numpy.typing.NDArray[numpy.float64]">;
using Uint16Arg = Arg<"numpy.typing.NDArray[numpy.uint16]">;
using Uint32Arg = Arg<"numpy.typing.NDArray[numpy.uint32]">;
using IdsArg =
    Arg<"numpy.typing.NDArray[numpy.uint32] | collections.abc.Sequence[typing.SupportsIndex]">;

template <typename T>
using Array =
    py::array_t<T, int{py::array::c_style} | int{py::detail::npy_api::NPY_ARRAY_ALIGNED_}>;

/// Lengths by dimension; -1 takes any.
using Shape = std::vector<py::ssize_t>;

/// `object` as an array, refused unless its dtype is one of `dtypes` and its shape fits. Neither
/// copied nor converted. `name` may hold the mesh or instance: messages begin with it.
py::array checked_array(const py::object& object, const std::string& name,
                        const std::vector<py::dtype>& dtypes, const Shape& shape);

/// As `checked_array`; copied only where the memory is not C-contiguous and aligned.
template <typename T>
Array<T> checked(const py::object& object, const std::string& name, const Shape& shape) {
  return Array<T>(checked_array(object, name, {py::dtype::of<T>()}, shape));
}

/// A whole number in [low, high].
std::int64_t checked_int(const py::object& object, const std::string& name, std::int64_t low,
                         std::int64_t high);

/// The id of a mesh, an instance and so on; whether it exists is for the scene to say.
std::uint32_t checked_id(const py::object& object, const std::string& name);

/// Ids, from an array of uint32 or a sequence of ints.
std::vector<std::uint32_t> checked_ids(const py::object& object, const std::string& name);

double checked_number(const py::object& object, const std::string& name);

/// Fills `out` from a sequence of as many numbers.
void checked_numbers(const py::object& object, const std::string& name, std::span<double> out);

template <std::size_t count>
std::array<double, count> checked_numbers(const py::object& object, const std::string& name) {
  std::array<double, count> numbers{};
  checked_numbers(object, name, numbers);
  return numbers;
}

/// A (4, 4) float64 array, column vectors.
Mat4d checked_matrix(const py::object& object, const std::string& name);

/// `rows`: 16 numbers in C order.
Mat4d matrix_from_rows(const double* rows);

/// The array's memory as packed `Element`s.
template <typename Element, typename T>
std::span<const Element> elements(const Array<T>& array) {
  const auto bytes = static_cast<std::size_t>(array.nbytes());
  return {reinterpret_cast<const Element*>(array.data()), bytes / sizeof(Element)};
}

}  // namespace regraft::bindings

namespace pybind11::detail {

template <regraft::bindings::TypeText type>
struct handle_type_name<regraft::bindings::Arg<type>> {
  static constexpr auto name = const_name(type.text);
};

}  // namespace pybind11::detail
