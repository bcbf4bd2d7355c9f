#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <random>

#include "regraft/accel/accelerator_state.h"
#include "regraft/accel/origin_cost.h"
#include "regraft/kdtree/statistics.h"

namespace regraft::accel {

namespace {

constexpr int epo_samples = 4096;

bool contains(const bvh::Node& node, const Vec3& p) {
  return p.x >= node.lo.x && p.x <= node.hi.x && p.y >= node.lo.y && p.y <= node.hi.y &&
         p.z >= node.lo.z && p.z <= node.hi.z;
}

/// Cost of the nodes under `index` that hold `p` but not the primitive `own`; `below` is called
/// for each primitive of such a leaf and for the leaf of `own`. Returns whether `own` is inside.
template <typename Below>
bool overlap(const bvh::Bvh& bvh, std::uint32_t index, const Vec3& p, std::uint32_t own,
             double& cost, const Below& below) {
  const bvh::Node& node = bvh.nodes[index];
  if (!contains(node, p)) return false;
  if (node.leaf()) {
    const auto* begin = bvh.prim_ids.data() + node.first;
    const bool inside = std::find(begin, begin + node.count, own) != begin + node.count;
    for (std::uint32_t i = 0; i < node.count; ++i) below(begin[i], inside);
    return inside;
  }
  const bool left = overlap(bvh, node.first, p, own, cost, below);
  const bool right = overlap(bvh, node.first + 1, p, own, cost, below);
  if (!left && !right) cost += 1.0;
  return left || right;
}

/// A triangle of the world, chosen by area.
struct Sample {
  std::uint32_t instance;
  std::uint32_t prim;
  std::uint32_t flat;  ///< its number among all triangles, as the flat layout counts them
  Vec3d object;        ///< in the frame of the instance's mesh
};

/// Cumulative world areas of the triangles of every instance.
struct AreaTable {
  std::vector<double> cumulative;
  std::vector<Sample> who;

  AreaTable(const Scene& scene, const InstanceSet& instances) {
    double sum = 0.0;
    std::uint32_t flat = 0;
    for (std::uint32_t i = 0; i < instances.views().size(); ++i) {
      const Mesh& mesh = instances.mesh(scene, i);
      const Mat3d linear(instances.frame(i));
      for (const std::uint32_t t : instances.tree(i).prims()) {
        const Sample who_is{i, t, flat++, {}};
        const Triangle& c = mesh.triangles[t];
        const Vec3d a(mesh.vertices[c.x]);
        const Vec3d n = glm::cross(linear * (Vec3d(mesh.vertices[c.y]) - a),
                                   linear * (Vec3d(mesh.vertices[c.z]) - a));
        const double area = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
        if (!(area > 0.0) || !std::isfinite(area)) continue;
        sum += area;
        cumulative.push_back(sum);
        who.push_back(who_is);
      }
    }
  }

  Sample draw(const Scene& scene, const InstanceSet& instances, std::mt19937_64& random) const {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double at = uniform(random) * cumulative.back();
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, at);
    Sample sample = who[std::size_t(found - cumulative.begin())];
    const Mesh& mesh = instances.mesh(scene, sample.instance);
    const Triangle& c = mesh.triangles[sample.prim];
    const double r = std::sqrt(uniform(random));
    const double v = uniform(random);
    sample.object = (1.0 - r) * Vec3d(mesh.vertices[c.x]) +
                    r * (1.0 - v) * Vec3d(mesh.vertices[c.y]) + r * v * Vec3d(mesh.vertices[c.z]);
    return sample;
  }
};

double mesh_overlap(const bvh::Bvh& bvh, const Vec3& p, std::uint32_t own) {
  double cost = 0.0;
  if (bvh.empty()) return cost;
  overlap(bvh, 0, p, own, cost, [&](std::uint32_t, bool inside) {
    if (!inside) cost += bvh::CostModel{}.leaf;
  });
  return cost;
}

/// End-point overlap (Aila, Karras, Laine, On Quality Metrics of Bounding Volume Hierarchies,
/// HPG 2013, Eq. 2), estimated at points spread over the surfaces.
double end_point_overlap(const Scene& scene, const InstanceSet& instances, const Tlas& tlas,
                         bool flat) {
  const AreaTable table(scene, instances);
  if (table.who.empty()) return 0.0;
  std::mt19937_64 random(1);
  double sum = 0.0;
  for (int s = 0; s < epo_samples; ++s) {
    const Sample sample = table.draw(scene, instances, random);
    const Vec3d world = Vec3d(instances.frame(sample.instance) * glm::dvec4(sample.object, 1.0));
    const std::uint32_t own = flat ? sample.flat : sample.instance;
    overlap(tlas.bvh(), 0, Vec3(world), own, sum, [&](std::uint32_t prim, bool inside) {
      if (flat) {
        if (!inside) sum += bvh::CostModel{}.leaf;
        return;
      }
      const Mat4d to_object = glm::inverse(instances.frame(prim));
      const Vec3 p(Vec3d(to_object * glm::dvec4(world, 1.0)));
      const bool mine = prim == sample.instance;
      sum += mesh_overlap(instances.tree(prim).bvh(), mine ? Vec3(sample.object) : p,
                          mine ? sample.prim : invalid_id);
    });
  }
  return sum / epo_samples;
}

/// Cells do not overlap and do not wear: no end-point overlap, and a fresh tree would be the same.
Quality whole_kdtree(const KdtreeScene& scene, std::uint64_t bytes_beside, Executor& executor) {
  scene.tree()->complete(executor);
  const kdtree::Statistics now = kdtree::measure(*scene.tree());
  Quality q;
  q.sah_cost = q.culling_efficiency = now.sam_cost;
  q.depth = now.depth;
  q.kdtree_q = now.quality(scene.tree()->builder().weight(), scene.tree()->config().cost);
  q.bytes = bytes_beside + scene.bytes();
  return q;
}

}  // namespace

Quality Accelerator::quality(const Scene& scene, bool fresh, Executor& executor) const {
  const State& state = *state_;
  Quality q;
  if (state.tlas.bounds().empty()) return q;
  if (state.kdtree.tree() != nullptr)
    return whole_kdtree(state.kdtree, state.bytes_without_kdtree, executor);
  state.finish_late();
  q.sah_cost = state.tlas.sah_cost(state.instances);
  q.culling_efficiency = state.tlas.culling_efficiency(state.instances);
  q.origin_cost =
      origin_cost(state.tlas, state.instances, state.last_options.layout == Layout::two_level);
  q.cost_ratio = state.cost_ratio();
  q.epo = end_point_overlap(scene, state.instances, state.tlas,
                            state.last_options.layout == Layout::flat);
  for (std::size_t i = 0; i < state.instances.views().size(); ++i)
    q.depth = std::max(q.depth, state.instances.tree(i).bvh().depth);
  q.depth = state.last_options.layout == Layout::flat ? state.tlas.bvh().depth
                                                      : q.depth + state.tlas.bvh().depth;
  q.bytes = state.last.memory_bytes;
  if (fresh) {
    Accelerator anew;
    ChangeSet all;
    for (std::uint32_t id = 0; id < scene.meshes().size(); ++id)
      if (scene.meshes()[id].alive) all.added_meshes.push_back(id);
    all.instance_set_changed = true;
    UpdateOptions options = state.last_options;
    options.policy = Policy::rebuild;
    anew.update(scene, all, options, state.last_width, executor);
    const double cost = anew.state_->tlas.sah_cost(anew.state_->instances);
    q.cost_ratio = cost > 0.0 ? q.sah_cost / cost : 1.0;
  }
  return q;
}

}  // namespace regraft::accel
