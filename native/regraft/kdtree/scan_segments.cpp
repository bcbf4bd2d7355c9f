#include "regraft/kdtree/scan_segments.h"

namespace regraft::kdtree {

double segment_bound(const SplitProblem& problem, const CostedSample& from,
                     const CostedSample& to) {
  // Of the largest weights in the segment, so that bounds still only rise as it is divided.
  constexpr double rounding = 1e-6;
  const double left = from.plane.left;
  const double right = to.plane.right;
  const double tests = problem.probability.linear()
                           ? std::min(from.p.left * left + from.p.right * right,
                                      to.p.left * left + to.p.right * right)
                           : from.p.left * left + to.p.right * right;
  return problem.cost.traverse +
         problem.cost.intersect *
             std::max(0.0, tests - rounding * (to.plane.left + from.plane.right));
}

}  // namespace regraft::kdtree
