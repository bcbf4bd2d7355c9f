#include "regraft/bvh/validate.h"

#include <algorithm>
#include <vector>

namespace regraft::bvh {

namespace {

class Validator {
 public:
  Validator(const Bvh& bvh, std::span<const Aabb> boxes)
      : bvh_(bvh), boxes_(boxes), reached_(bvh.nodes.size(), false) {}

  Aabb visit(std::uint32_t index, std::uint32_t depth) {
    if (!error_.empty()) return {};
    if (index >= bvh_.nodes.size() || reached_[index])
      return fail(index, "is out of range or reached twice");
    reached_[index] = true;
    deepest_ = std::max(deepest_, depth);
    if (depth > max_depth) return fail(index, "is too deep");
    const Node& node = bvh_.nodes[index];
    const Aabb box = node.leaf() ? leaf_box(index) : inner_box(index, depth);
    if (error_.empty() && !(box == node.bounds()))
      return fail(index, "has a box that is not tight");
    return box;
  }

  std::string finish(std::span<const std::uint32_t> ids) {
    if (error_.empty() && deepest_ != bvh_.depth) fail(0, "has another depth than recorded");
    for (const std::uint32_t first : bvh_.free_pairs) check_free(first);
    for (std::uint32_t i = 0; i < reached_.size() && error_.empty(); ++i)
      if (!reached_[i] && i != 1) fail(i, "is not reachable");
    std::vector<std::uint32_t> wanted(ids.begin(), ids.end());
    std::sort(wanted.begin(), wanted.end());
    std::sort(found_.begin(), found_.end());
    if (error_.empty() && wanted != found_)
      fail(0, "does not hold every primitive in exactly one leaf");
    return error_;
  }

 private:
  Aabb fail(std::uint32_t index, const char* what) {
    if (error_.empty()) error_ = "node " + std::to_string(index) + " " + what;
    return {};
  }

  void check_free(std::uint32_t first) {
    if (first < 2 || first % 2 != 0 || first + 1 >= reached_.size() || reached_[first] ||
        reached_[first + 1]) {
      fail(first, "is free and in use, or free twice");
      return;
    }
    if (!(bvh_.nodes[first] == Node{} && bvh_.nodes[first + 1] == Node{}))
      fail(first, "is free and not empty");
    reached_[first] = reached_[first + 1] = true;
  }

  Aabb leaf_box(std::uint32_t index) {
    const Node& node = bvh_.nodes[index];
    if (node.count > max_leaf_size || node.first + node.count > bvh_.prim_ids.size())
      return fail(index, "has a primitive range out of bounds");
    Aabb box;
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const std::uint32_t prim = bvh_.prim_ids[node.first + i];
      if (prim >= boxes_.size()) return fail(index, "names an unknown primitive");
      found_.push_back(prim);
      box.extend(boxes_[prim]);
    }
    return box;
  }

  Aabb inner_box(std::uint32_t index, std::uint32_t depth) {
    const std::uint32_t first = bvh_.nodes[index].first;
    if (first < 2 || first % 2 != 0) return fail(index, "has misplaced children");
    Aabb box = visit(first, depth + 1);
    box.extend(visit(first + 1, depth + 1));
    return box;
  }

  const Bvh& bvh_;
  std::span<const Aabb> boxes_;
  std::vector<bool> reached_;
  std::vector<std::uint32_t> found_;
  std::uint32_t deepest_ = 0;
  std::string error_;
};

}  // namespace

std::string validate(const Bvh& bvh, std::span<const Aabb> boxes,
                     std::span<const std::uint32_t> ids) {
  if (bvh.empty()) return ids.empty() ? "" : "an empty tree holds no primitives";
  Validator validator(bvh, boxes);
  validator.visit(0, 0);
  return validator.finish(ids);
}

}  // namespace regraft::bvh
