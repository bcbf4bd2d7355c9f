#include "trace/bed.h"

#include <algorithm>
#include <array>
#include <vector>

namespace regraft::test {

namespace {

using accel::Layout;
using accel::Policy;
using accel::Structure;

constexpr std::array<Setup, 7> all_setups{
    {{Policy::refit, Layout::two_level},
     {Policy::rebuild, Layout::two_level},
     {Policy::automatic, Layout::two_level},
     {Policy::refit, Layout::flat},
     {Policy::rebuild, Layout::flat},
     {Policy::automatic, Layout::flat},
     {Policy::automatic, Layout::two_level, Structure::kdtree}}};
constexpr Policy every_policy[] = {
    Policy::refit,    Policy::rebuild,   Policy::automatic,        Policy::lm,
    Policy::rtdeform, Policy::selective, Policy::selective_rotate, Policy::shot};
constexpr unsigned pool_sizes[] = {1, 2, 5};

}  // namespace

std::ostream& operator<<(std::ostream& out, const Setup& setup) {
  return out << name(setup.policy) << ' ' << name(setup.layout) << ' ' << name(setup.structure);
}

std::span<const Setup> setups() {
  return all_setups;
}

std::span<const Setup> policies() {
  static const std::vector<Setup> all = [] {
    std::vector<Setup> list{{Policy::automatic, Layout::two_level, Structure::kdtree}};
    for (const Policy policy : every_policy)
      for (const Layout layout : {Layout::two_level, Layout::flat})
        list.push_back({policy, layout});
    return list;
  }();
  return all;
}

Bed::Bed() {
  for (const Setup& setup : all_setups)
    for (const int width : {4, 8}) add_slot(setup, width, false);
  add_slot(all_setups[0], 8, true);
}

Bed::Bed(std::span<const Setup> kinds) {
  for (const Setup& setup : kinds) add_slot(setup, slots_.size() / 2 % 2 == 0 ? 8 : 4, false);
}

void Bed::note_rays(std::uint64_t rays) {
  for (Slot& slot : slots_) slot.accelerator.note_rays(rays);
}

void Bed::add_slot(const Setup& setup, int width, bool fickle) {
  slots_.push_back({setup, width, pool_sizes[slots_.size() % 3], fickle, {}, {}});
}

/// Another policy, layout and width at each update.
void Bed::make_fickle(Slot& slot) const {
  slot.setup = all_setups[(5 * updates_) % all_setups.size()];
  slot.setup.layout = (updates_ / 2) % 2 == 0 ? Layout::flat : Layout::two_level;
  slot.width = updates_ % 3 == 2 ? 4 : 8;
}

std::string Bed::update() {
  const ChangeSet changes = scene.take_changes();
  std::string error;
  ++updates_;
  for (Slot& slot : slots_) {
    if (slot.fickle) make_fickle(slot);
    accel::UpdateOptions options;
    options.policy = slot.setup.policy;
    options.layout = slot.setup.layout;
    options.structure = slot.setup.structure;
    slot.statistics =
        slot.accelerator.update(scene, changes, options, slot.width, pool(slot.threads));
    const std::string invalid = slot.accelerator.validate(scene);
    if (error.empty() && !invalid.empty()) error = text(slot.setup, ": ", invalid);
  }
  return error;
}

std::string Bed::differences(std::span<const Ray> rays) const {
  const std::vector<Found> wanted = hits(rays);
  for (const Slot& slot : slots_) {
    const std::string error = difference(slot.accelerator.view(), slot.width, rays, wanted);
    if (!error.empty()) return text(slot.setup, slot.fickle ? " fickle " : " ", error);
  }
  return "";
}

std::string Bed::complaints(std::span<const Ray> rays, double ulps) const {
  const SceneOracle oracle(scene, ulps);
  const std::vector<Found> found = hits(rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    std::string error = oracle.complaint(rays[i], found[i]);
    if (!error.empty()) return error;
  }
  return "";
}

std::string Bed::verdict(std::uint64_t seed, std::size_t count) const {
  const std::vector<Ray> rays = nasty_rays(SceneOracle(scene), seed, count);
  std::string error = differences(rays);
  if (error.empty()) error = complaints(rays);
  if (!error.empty()) return error;
  const std::vector<Interval> intervals = tight_intervals(rays, hits(rays));
  std::vector<Ray> tight;
  for (const Interval& interval : intervals) tight.push_back(interval.ray);
  const std::vector<Found> found = hits(tight);
  for (std::size_t i = 0; i < tight.size(); ++i)
    if (!intervals[i].right(found[i]))
      return text("found ", intervals[i].before, ", but for ", tight[i], " found ", found[i]);
  return differences(tight);
}

std::string Bed::problems(std::uint64_t seed, std::size_t count) {
  const std::string invalid = update();
  return invalid.empty() ? verdict(seed, count) : invalid;
}

const accel::UpdateStatistics& Bed::statistics(const Setup& setup) const {
  for (const Slot& slot : slots_)
    if (slot.setup == setup && !slot.fickle) return slot.statistics;
  return slots_[0].statistics;
}

bool Bed::warns(const Setup& setup, const std::string& words) const {
  const std::vector<std::string>& said = statistics(setup).warnings;
  return std::any_of(said.begin(), said.end(), [&](const std::string& sentence) {
    return sentence.find(words) != std::string::npos;
  });
}

}  // namespace regraft::test
