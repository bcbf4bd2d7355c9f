#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/typing.h>

#include "regraft/render/frame.h"

namespace regraft::bindings {

using Sentences = pybind11::typing::List<pybind11::str>;

/// Statistics as Python sees them: the two lists are real ones, to be appended to.
template <typename Native>
struct BoundStatistics : Native {
  BoundStatistics() = default;
  explicit BoundStatistics(Native native) : Native(std::move(native)) {
    for (const std::string& sentence : this->left_out) left_out_list.append(sentence);
    for (const std::string& sentence : this->warnings) warnings_list.append(sentence);
  }

  Sentences left_out_list;
  Sentences warnings_list;
};

using UpdateStatistics = BoundStatistics<accel::UpdateStatistics>;
using FrameStatistics = BoundStatistics<render::FrameStatistics>;

}  // namespace regraft::bindings
