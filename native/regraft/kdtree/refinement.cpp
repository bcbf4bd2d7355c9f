#include "regraft/kdtree/refinement.h"

namespace regraft::kdtree {

bool cut(Aabb& box, const Aabb& voxel) {
  for (int k = 0; k < 3; ++k) {
    const float lo = box.lo[k], hi = box.hi[k];
    const bool flat = lo == hi || voxel.lo[k] == voxel.hi[k];
    if (flat ? lo > voxel.hi[k] || hi < voxel.lo[k] : lo >= voxel.hi[k] || hi <= voxel.lo[k])
      return false;
    box.lo[k] = lo > voxel.lo[k] ? lo : voxel.lo[k];
    box.hi[k] = hi < voxel.hi[k] ? hi : voxel.hi[k];
  }
  return true;
}

Refinement::Refinement(const HierarchyView& view, Refine order, const Pending& node)
    : view_(view), order_(order), voxel_(node.voxel), list_(node.list) {
  open_.resize(list_.size(), 0);
  size_ = list_.size();
  for (std::size_t i = 0; i < list_.size(); ++i) note(i);
}

double Refinement::weight() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < list_.size(); ++i)
    if (open_[i] == 0) sum += list_[i].weight;
  return sum;
}

bool Refinement::open_straddlers(const Split& split, std::size_t count) {
  std::vector<std::uint32_t> across;
  for (std::size_t i = next_; i < inner_.size(); ++i) {
    const HierarchyEntry& e = list_[inner_[i]];
    if (e.box.lo[split.axis] < split.position && e.box.hi[split.axis] > split.position)
      across.push_back(inner_[i]);
  }
  if (across.size() > count) {
    std::stable_sort(across.begin(), across.end(), [&](std::uint32_t a, std::uint32_t b) {
      return list_[a].weight > list_[b].weight;
    });
    across.resize(count);
  }
  for (const std::uint32_t i : across) open(i);
  std::erase_if(inner_, [&](std::uint32_t i) { return open_[i] != 0; });
  next_ = 0;
  if (order_ == Refine::area) std::make_heap(inner_.begin(), inner_.end(), before());
  return !across.empty();
}

std::span<const HierarchyEntry> Refinement::compacted() {
  if (size_ == list_.size()) return list_;
  std::vector<std::uint32_t> place(list_.size());
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    place[i] = kept;
    if (open_[i] == 0) list_[kept++] = list_[i];
  }
  list_.resize(kept);
  open_.assign(kept, 0);
  // Their order is as it was: so is that of the queue or heap.
  inner_.erase(inner_.begin(), inner_.begin() + std::ptrdiff_t(next_));
  next_ = 0;
  for (std::uint32_t& i : inner_) i = place[i];
  return list_;
}

void Refinement::note(std::size_t i) {
  if (list_[i].primitive()) return;
  inner_.push_back(std::uint32_t(i));
  if (order_ == Refine::area) std::push_heap(inner_.begin(), inner_.end(), before());
}

std::uint32_t Refinement::pop() {
  if (order_ == Refine::fifo) return inner_[next_++];
  std::pop_heap(inner_.begin(), inner_.end(), before());
  const std::uint32_t i = inner_.back();
  inner_.pop_back();
  return i;
}

void Refinement::open(std::uint32_t i) {
  children_.clear();
  view_.open(list_[i], children_);
  open_[i] = 1;
  --size_;
  for (HierarchyEntry& child : children_) {
    const Aabb whole = child.box;
    if (!cut(child.box, voxel_)) continue;
    if (child.primitive() && child.box != whole) child.box = view_.clip(child, voxel_);
    if (child.box.empty()) continue;
    list_.push_back(child);
    open_.push_back(0);
    ++size_;
    note(list_.size() - 1);
  }
}

}  // namespace regraft::kdtree
