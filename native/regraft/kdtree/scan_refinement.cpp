#include "regraft/kdtree/scan_refinement.h"

#include <algorithm>
#include <utility>

namespace regraft::kdtree {
namespace {

constexpr std::size_t parts = 8;
/// So few events are sorted rather than divided further.
constexpr std::uint32_t few_events = 64;

/// Orders a heap so that its first has the lowest bound; ties by place, so that the order in
/// which segments were made does not matter.
bool later(const ScanSegment& a, const ScanSegment& b) {
  if (a.bound != b.bound) return a.bound > b.bound;
  if (a.axis != b.axis) return a.axis > b.axis;
  return a.from.position > b.from.position;
}

/// Calls `use(axis, bin, event)` for every bound of an entry strictly inside the voxel.
template <class Use>
void for_each_event(std::span<const SplitEntry> entries, const EventBins& bins, const Use& use) {
  using Kind = SplitEvent::Kind;
  const auto inside = [&bins](int bin) { return bin > 0 && bin <= bins.count(); };
  for (const SplitEntry& entry : entries) {
    if (!(entry.weight > 0.0)) continue;
    const EventBins::Index index = bins.index(entry);
    for (int k = 0; k < 3; ++k) {
      const int lo = index.lo[std::size_t(k)];
      const int hi = index.hi[std::size_t(k)];
      const bool flat = entry.box.lo[k] == entry.box.hi[k];
      if (inside(lo))
        use(k, lo, SplitEvent{entry.box.lo[k], flat ? Kind::flat : Kind::start, entry.weight});
      if (inside(hi) && !flat) use(k, hi, SplitEvent{entry.box.hi[k], Kind::end, entry.weight});
    }
  }
}

}  // namespace

ScanRefinement::Extent ScanRefinement::extent_of(std::span<const SplitEvent> events) {
  Extent extent{events.front().position, events.front().position};
  for (const SplitEvent& event : events) {
    extent.lo = std::min(extent.lo, double(event.position));
    extent.hi = std::max(extent.hi, double(event.position));
  }
  return extent;
}

double ScanRefinement::lower_bound() const {
  double least = std::numeric_limits<double>::infinity();
  for (const ScanSegment& segment : segments_) least = std::min(least, segment.bound);
  return least;
}

void ScanRefinement::run(Split& best, const SplitProblem& problem, const Goal& goal,
                         std::span<const SplitEntry> entries, const EventBins& bins) {
  const auto open = std::partition(segments_.begin(), segments_.end(), [&](const ScanSegment& s) {
    return !goal.reached(best.cost, s.bound);
  });
  // What is not open now never will be: the best cost only falls.
  double closed = best.cost;
  for (auto s = open; s != segments_.end(); ++s) closed = std::min(closed, s->bound);
  segments_.erase(open, segments_.end());
  if (!segments_.empty()) collect(entries, bins);
  std::make_heap(segments_.begin(), segments_.end(), later);
  while (!segments_.empty() && !goal.reached(best.cost, segments_.front().bound)) {
    std::pop_heap(segments_.begin(), segments_.end(), later);
    const ScanSegment segment = segments_.back();
    segments_.pop_back();
    const std::span<SplitEvent> events(&events_[segment.first], segment.count);
    const Extent extent = extent_of(events);
    // Bounds in one place cannot be divided, however many.
    if (events.size() <= few_events || extent.lo == extent.hi)
      sweep_events(best, problem, segment.axis, events,
                   {segment.from.left, segment.from.right, 0.0});
    else
      divide(problem, segment, extent);
  }
  best.lower_bound = std::min({best.cost, closed, lower_bound()});
}

void ScanRefinement::collect(std::span<const SplitEntry> entries, const EventBins& bins) {
  std::array<std::array<int, EventBins::max_count + 1>, 3> owner;
  for (auto& axis : owner) axis.fill(-1);
  for (std::size_t i = 0; i < segments_.size(); ++i)
    owner[std::size_t(segments_[i].axis)][std::size_t(segments_[i].index)] = int(i);
  divided_.clear();
  owners_.clear();
  for_each_event(entries, bins, [&](int axis, int bin, const SplitEvent& event) {
    const int i = owner[std::size_t(axis)][std::size_t(bin)];
    if (i < 0) return;
    ++segments_[std::size_t(i)].count;
    owners_.push_back(std::uint32_t(i));
    divided_.push_back(event);
  });
  std::uint32_t total = 0;
  for (ScanSegment& segment : segments_) {
    segment.first = total;
    total += std::exchange(segment.count, 0u);
  }
  events_.resize(total);
  for (std::size_t i = 0; i < total; ++i) {
    ScanSegment& segment = segments_[owners_[i]];
    events_[segment.first + segment.count++] = divided_[i];
  }
}

void ScanRefinement::divide(const SplitProblem& problem, const ScanSegment& segment,
                            const Extent& extent) {
  const std::span<SplitEvent> events(&events_[segment.first], segment.count);
  const double width = extent.hi - extent.lo;
  const auto part_of = [&](const SplitEvent& event) {
    return std::min(std::size_t((double(event.position) - extent.lo) / width * parts), parts - 1);
  };
  std::array<std::uint32_t, parts + 1> first{};
  std::array<double, parts> lefts{};
  std::array<double, parts> rights{};
  for (const SplitEvent& event : events) {
    const std::size_t i = part_of(event);
    ++first[i + 1];
    if (event.kind != SplitEvent::Kind::end) lefts[i] += event.weight;
    if (event.kind != SplitEvent::Kind::start) rights[i] += event.weight;
  }
  for (std::size_t i = 0; i < parts; ++i) first[i + 1] += first[i];
  divided_.resize(events.size());
  auto next = first;
  for (const SplitEvent& event : events) divided_[next[part_of(event)]++] = event;
  std::copy(divided_.begin(), divided_.end(), events.begin());

  const int axis = segment.axis;
  CostedSample from(problem, axis, {extent.lo, segment.from.left, segment.from.right, 0});
  for (std::size_t i = 0; i < parts; ++i) {
    const double position = extent.lo + width * double(i + 1) / parts;
    const CostedSample to(problem, axis,
                          {position, from.plane.left + lefts[i], from.plane.right - rights[i], 0});
    if (const std::uint32_t count = first[i + 1] - first[i]; count > 0) {
      const double bound = std::max(segment.bound, segment_bound(problem, from, to));
      add({bound, from.plane, to.plane, axis, 0, segment.first + first[i], count});
      std::push_heap(segments_.begin(), segments_.end(), later);
    }
    from = to;
  }
}

}  // namespace regraft::kdtree
