#include <algorithm>

#include "regraft/accel/accelerator_state.h"
#include "regraft/kdtree/statistics.h"

// What an accelerator tells of its trees and of what was done to them.

namespace regraft::accel {

namespace {

std::string mesh_label(const Mesh& mesh, std::uint32_t id) {
  return "mesh " + std::to_string(id) + (mesh.name.empty() ? "" : " '" + mesh.name + "'");
}

}  // namespace

void add(const TreeWork& work, UpdateStatistics& s) {
  s.nodes_refitted += work.nodes_refitted;
  s.nodes_rebuilt += work.nodes_rebuilt;
  s.pairs_considered += work.pairs_considered;
  s.select_ms += work.select_ms;
  for (const bvh::Restructured& operation : work.operations) {
    s.pairs_restructured += operation.realised != 0.0;
    s.predicted_benefits.push_back(operation.predicted);
    s.realised_savings.push_back(operation.realised);
  }
}

std::string reason(const TreeWork& work) {
  switch (work.done) {
    case TreeUpdate::none:
      return "auto: no tree's primitives moved: no refit";
    case TreeUpdate::refit:
      return "auto: nothing worth restructuring: refit only";
    case TreeUpdate::restructure:
      return "auto: damage is local: no tree built anew";
    case TreeUpdate::rebuild:
      break;
  }
  return "auto: a tree is new, or its damage costs more than building it anew: not mended";
}

void Accelerator::State::warn_of_dropped(const Scene& scene) {
  mesh_warnings.clear();
  std::uint64_t zero_area = 0;
  for (std::uint32_t id = 0; id < blases.size(); ++id) {
    zero_area += blases[id].zero_area();
    if (blases[id].non_finite() != 0)
      mesh_warnings.push_back(mesh_label(scene.meshes()[id], id) + ": " +
                              std::to_string(blases[id].non_finite()) +
                              " triangles with non-finite vertices left out");
  }
  if (zero_area != 0)
    mesh_warnings.push_back(std::to_string(zero_area) + " triangles of zero area left out");
}

void Accelerator::State::count(const Scene& scene, UpdateStatistics& s) const {
  s.nodes = tlas.bvh().node_count();
  for (const trace::InstanceView& v : instances.views())
    s.triangles += scene.meshes()[scene.instances()[v.instance_id].mesh].triangles.size();
  s.instances = instances.views().size();
  s.memory_bytes = scene.bytes() + instances.bytes() + tlas.bytes();
  for (std::size_t id = 0; id < blases.size(); ++id) {
    s.nodes += blases[id].bvh().node_count();
    s.memory_bytes += blases[id].bytes() + normals[id].bytes();
  }
  s.culling_efficiency = tlas.culling_efficiency(instances);
  s.cost_ratio = cost_ratio();
}

/// How worn the trees are.
double Accelerator::State::cost_ratio() const {
  const double unworn = tlas.unworn_cost(instances);
  return unworn > 0.0 ? tlas.sah_cost(instances) / unworn : 1.0;
}

void Accelerator::State::list_left_out(const Scene& scene, const ChangeSet& changes,
                                       const MeshPlan& plan, UpdateStatistics& s) const {
  std::size_t alive = 0;
  for (const Mesh& mesh : scene.meshes()) alive += mesh.alive;
  const std::size_t changed = plan.update.size() + plan.postpone.size() + plan.hidden;
  if (alive > changed)
    s.left_out.push_back(std::to_string(alive - changed) + " of " + std::to_string(alive) +
                         " meshes unchanged: their trees not touched");
  if (plan.hidden != 0)
    s.left_out.push_back(std::to_string(plan.hidden) + " changed meshes hidden: not updated");
  if (!plan.postpone.empty()) {
    std::size_t bytes = 0;
    for (const std::uint32_t id : plan.postpone) bytes += blases[id].bytes();
    s.left_out.push_back(std::to_string(plan.postpone.size()) +
                         " deformed meshes far from all rays of late: only bounded, " +
                         std::to_string(bytes) + " bytes of trees wait until rays come near");
  }
  if (changes.deformed_meshes.empty() && changes.retopologised_meshes.empty() &&
      changes.added_meshes.empty())
    s.left_out.emplace_back("no deformation: no refit of meshes");
}

UpdateStatistics Accelerator::State::unchanged(const UpdateOptions& options) const {
  UpdateStatistics s = last;
  s.policy = name(options.policy);
  s.clear_work("nothing changed: no update");
  return s;
}

void Accelerator::count_kdtree(UpdateStatistics& statistics) const {
  const kdtree::KdTree* tree = state_->kdtree.tree();
  if (tree == nullptr) return;
  const kdtree::Statistics now = kdtree::measure(*tree);
  statistics.kdtree_nodes = now.nodes();
  statistics.kdtree_built_fraction = now.built_fraction;
  statistics.kdtree_unbuilt_nodes = now.unbuilt;
  statistics.kdtree_large_leaves = now.large_leaves;
  statistics.culling_efficiency = now.sam_cost;
  statistics.memory_bytes = state_->bytes_without_kdtree + state_->kdtree.bytes();
}

std::string Accelerator::validate(const Scene& scene) const {
  std::string error = state_->tlas.validate();
  if (!error.empty()) return "top tree: " + error;
  error = state_->kdtree.validate();
  if (!error.empty()) return "k-d tree: " + error;
  for (std::uint32_t id = 0; id < state_->blases.size(); ++id) {
    const Blas& blas = state_->blases[id];
    if (!blas.exists() || state_->is_behind(id)) continue;
    error = blas.validate(scene.meshes()[id]);
    if (!error.empty()) return mesh_label(scene.meshes()[id], id) + ": " + error;
  }
  return "";
}

}  // namespace regraft::accel
