#pragma once

#include <algorithm>

#include "args.h"
#include "python_poll.h"
#include "ray_batch.h"
#include "regraft/core/executor.h"

namespace regraft::bindings {

using RealsArg = Arg<"numpy.typing.NDArray[numpy.float32] | numpy.typing.NDArray[numpy.float64]">;

/// N rows of three floats or doubles; any N for `count` < 0. Throws as `checked_array` does.
inline py::array real_array(const py::object& object, const char* name, py::ssize_t count) {
  return checked_array(object, name, {py::dtype::of<float>(), py::dtype::of<double>()}, {count, 3});
}

inline Rows rows(const py::array& array) {
  return {static_cast<const std::byte*>(array.data()), array.strides(0), array.strides(1),
          array.itemsize() == sizeof(double)};
}

/// How N blocks of work, such as packets of rays, are shared out.
struct Sharing {
  /// Up to here, waking other threads costs more than it brings.
  std::size_t alone = 4;
  /// From here on the work takes long enough for somebody to want to interrupt it.
  std::size_t polled = 4096;
  std::size_t grain = 16;
};

/// Calls `work(begin, end)` for all blocks on all threads, without the GIL.
template <typename Work>
void for_blocks(Executor& executor, std::size_t blocks, const Sharing& sharing, const Work& work) {
  if (blocks <= sharing.alone) return work(0, blocks);
  const std::size_t grain = sharing.grain;
  PythonPoll poll;
  {
    const py::gil_scoped_release no_gil;
    if (blocks < sharing.polled) {
      executor.parallel_for(blocks, grain, work);
    } else {
      executor.parallel_for_polled(
          (blocks + grain - 1) / grain,
          [&](std::size_t i) { work(i * grain, std::min(blocks, (i + 1) * grain)); },
          [&] { return poll([] { return true; }); });
    }
  }
  poll.rethrow();
}

}  // namespace regraft::bindings
