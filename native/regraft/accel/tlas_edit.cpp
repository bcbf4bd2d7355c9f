#include <algorithm>

#include "regraft/accel/tlas.h"

namespace regraft::accel {

namespace {

/// The new number of each primitive before; `old_begin`, `begin`: where those of instances begin.
std::vector<std::uint32_t> renumbered(const std::vector<std::uint32_t>& old_begin,
                                      const std::vector<std::uint32_t>& begin,
                                      const std::vector<std::uint32_t>& new_places) {
  std::vector<std::uint32_t> numbers(old_begin.back(), invalid_id);
  for (std::size_t i = 0; i < new_places.size(); ++i) {
    const std::uint32_t place = new_places[i];
    if (place == invalid_id) continue;
    for (std::uint32_t p = old_begin[i]; p < old_begin[i + 1]; ++p)
      numbers[p] = begin[place] + (p - old_begin[i]);
  }
  return numbers;
}

}  // namespace

/// Takes out of the tree what is gone and puts in what is new, an instance's primitives together.
/// @return false if the tree is to be built anew.
bool Tlas::edit(const Scene& scene, const InstanceSet& instances,
                const InstanceSet::Changes& placed, const Tending& how, Executor& executor,
                TreeWork& work) {
  const std::vector<std::uint32_t> old_begin = std::move(begin_), old_ids = std::move(ids_);
  collect_primitives(scene, instances, executor);
  const std::vector<std::uint32_t> new_ids = renumbered(old_begin, begin_, placed.new_places);
  std::vector<std::uint8_t> stays(instances.views().size(), 0);
  for (const std::uint32_t place : placed.new_places)
    if (place != invalid_id) stays[place] = 1;
  ids_.clear();
  for (const std::uint32_t id : old_ids)
    if (new_ids[id] != invalid_id) ids_.push_back(new_ids[id]);
  std::size_t count = old_ids.size() - ids_.size();
  std::vector<std::vector<std::uint32_t>> added;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (stays[i] != 0) continue;
    std::vector<std::uint32_t>& chunk = added.emplace_back();
    for (std::uint32_t p = begin_[i]; p < begin_[i + 1]; ++p)
      if (!boxes_[p].empty()) chunk.push_back(p);
    ids_.insert(ids_.end(), chunk.begin(), chunk.end());
    count += chunk.size();
  }
  std::sort(ids_.begin(), ids_.end());
  const auto box = [&](std::uint32_t i) { return bvh::Box4(boxes_[i]); };
  return holds_all() && tree_.edit({new_ids, added}, count, box, builder(), how, executor, work);
}

}  // namespace regraft::accel
