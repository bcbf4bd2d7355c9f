#include "regraft/kdtree/split_event.h"

#include <algorithm>

namespace regraft::kdtree {

void sweep_events(Split& best, const SplitProblem& problem, int axis, std::span<SplitEvent> events,
                  Sides sides) {
  std::sort(events.begin(), events.end(),
            [](const SplitEvent& a, const SplitEvent& b) { return a.position < b.position; });
  for (std::size_t i = 0; i < events.size();) {
    const float position = events[i].position;
    std::array<double, 3> met{};
    for (; i < events.size() && events[i].position == position; ++i)
      met[std::size_t(events[i].kind)] += events[i].weight;
    sides.flat = met[std::size_t(SplitEvent::Kind::flat)];
    sides.right -= met[std::size_t(SplitEvent::Kind::end)] + sides.flat;
    const ChildProbability::Pair p = problem.probability.at(axis, position);
    offer(best, axis, position, plane_cost(problem.cost, p, sides), p.left < p.right);
    ++best.samples;
    sides.left += met[std::size_t(SplitEvent::Kind::start)] + sides.flat;
  }
}

}  // namespace regraft::kdtree
