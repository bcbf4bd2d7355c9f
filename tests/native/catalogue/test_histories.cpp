#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "trace/bed.h"

// Whatever is done to a scene, in whatever order: it answers as one that was built anew.

namespace regraft::test {
namespace {

enum class Deed {
  add,
  instance_again,
  remove,
  deform,
  retopologise,
  hide_or_show,
  move,
  teleport,
  squash,
  mend,
  keep_otherwise,
  look_elsewhere
};
constexpr const char* deed_names[] = {
    "add",  "instance again", "remove", "deform", "retopologise",   "hide or show",
    "move", "teleport",       "squash", "mend",   "keep otherwise", "look elsewhere"};

/// One change; what it is done to and how follow from the seed.
struct Edit {
  Deed deed;
  std::uint64_t seed;
};
std::ostream& operator<<(std::ostream& out, const Edit& edit) {
  return out << deed_names[int(edit.deed)] << ' ' << edit.seed;
}

/// Few triangles of any kind.
Geometry any_geometry(Random& random) {
  switch (random.below(5)) {
    case 0:
      return sphere(4, 5);
    case 1:
      return floor_grid(4, 1.0f);
    case 2:
      return soup(30, random.below(1000), 1.0, 0.4);
    case 3:
      return needles(20, random.below(1000), 1.0, 1e-3);
    default:
      return {};
  }
}

/// A scene that is edited, and the trees that follow.
class Edited {
 public:
  void apply(const Edit& edit) {
    Random random(edit.seed);
    if (instances_.empty() || edit.deed == Deed::add) {
      const std::uint32_t mesh = add_mesh(scene_, any_geometry(random));
      instances_.push_back(add_instance(scene_, mesh, placed(random)));
      return;
    }
    const std::uint32_t id = instances_[random.below(instances_.size())];
    const std::uint32_t mesh = scene_.instances()[id].mesh;
    switch (edit.deed) {
      case Deed::instance_again:
        instances_.push_back(add_instance(scene_, mesh, placed(random)));
        break;
      case Deed::remove:
        remove(id);
        break;
      case Deed::deform:
        deform(mesh, random);
        break;
      case Deed::retopologise:
        scene_.set_mesh(mesh, any_geometry(random).data());
        break;
      case Deed::hide_or_show:
        scene_.set_visible(id, !scene_.instances()[id].visible);
        break;
      case Deed::mend:
        accelerator_.note_rays(100'000'000);
        break;
      case Deed::keep_otherwise:
        setup = policies()[random.below(policies().size())];
        width_ = random.below(2) == 0 ? 4 : 8;
        break;
      case Deed::look_elsewhere:
        watched_ = random.below(3) == 0 ? invalid_id : id;
        break;
      default:
        place(id, edit.deed, random);
    }
  }

  /// Brings the trees up to date and traces; "" if all is as in a scene built anew.
  std::string flaw() {
    accel::UpdateOptions options;
    options.policy = setup.policy;
    options.layout = setup.layout;
    options.structure = setup.structure;
    accelerator_.update(scene_, scene_.take_changes(), options, width_, pool(2));
    std::string error = accelerator_.validate(scene_);
    if (!error.empty()) return error;
    const std::vector<Ray> rays = in_view(nasty_rays(SceneOracle(scene_), ++updates_, 12));
    error = difference(accelerator_.view(), width_, rays, hits_anew(scene_, rays));
    accelerator_.note_rays(rays.size());
    return error;
  }

  Setup setup{accel::Policy::automatic, accel::Layout::two_level};

 private:
  /// Of rays that hit the watched instance what is close to the hit: other objects leave the view.
  /// All of them, if none is watched.
  std::vector<Ray> in_view(const std::vector<Ray>& rays) const {
    if (watched_ == invalid_id) return rays;
    std::vector<Ray> close;
    const std::vector<Found> hits = hits_anew(scene_, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (hits[i].instance != watched_) continue;
      close.push_back(rays[i]);
      close.back().t_near = close.back().t_far = hits[i].t;
    }
    return close;
  }

  static Mat4d placed(Random& random) {
    const Mat4d moved = glm::translate(Mat4d(1.0), random.in_box(2.0));
    return random.below(3) == 0 ? moved : glm::rotate(moved, random.uniform(0, 6), random.way());
  }

  void place(std::uint32_t id, Deed deed, Random& random) {
    Mat4d m = placed(random);
    if (deed == Deed::teleport)
      m = glm::translate(Mat4d(1.0), random.below(2) == 0 ? random.in_box(1e6) : Vec3d(0.0));
    if (deed == Deed::squash) m[int(random.below(3))] *= random.below(2) == 0 ? 0.0 : -1e-4;
    scene_.set_transform(id, m);
  }

  /// All of a mesh, or a few of its vertices; some of them leave for good or lose their number.
  void deform(std::uint32_t mesh, Random& random) {
    std::vector<Vec3> vertices = scene_.meshes()[mesh].vertices;
    const bool few = random.below(2) == 0;
    for (Vec3& v : vertices)
      if (!few || random.below(8) == 0) v += Vec3(random.in_box(0.5));
    if (!vertices.empty() && random.below(4) == 0)
      vertices[random.below(vertices.size())] = Vec3(random.below(2) == 0 ? nan : 1e20f);
    if (random.below(8) == 0) vertices.assign(vertices.size(), Vec3(1.0f));
    scene_.set_vertices(mesh, vertices);
  }

  void remove(std::uint32_t id) {
    const std::uint32_t mesh = scene_.instances()[id].mesh;
    scene_.remove_instance(id);
    std::erase(instances_, id);
    if (scene_.meshes()[mesh].instance_count == 0) scene_.remove_mesh(mesh);
  }

  Scene scene_;
  accel::Accelerator accelerator_;
  int width_ = 8;
  std::uint64_t updates_ = 0;
  std::uint32_t watched_ = invalid_id;
  std::vector<std::uint32_t> instances_;
};

/// Those that keep a tree for each mesh.
std::vector<Setup> two_level_policies() {
  std::vector<Setup> setups;
  for (const Setup& setup : policies())
    if (setup.layout == accel::Layout::two_level && setup.structure == accel::Structure::bvh)
      setups.push_back(setup);
  return setups;
}

rc::Gen<std::vector<Edit>> histories(const std::vector<Deed>& deeds, int length) {
  const auto edit =
      rc::gen::construct<Edit>(rc::gen::elementOf(deeds), rc::gen::arbitrary<std::uint64_t>());
  return rc::gen::resize(length, rc::gen::container<std::vector<Edit>>(edit));
}

std::vector<Deed> all_deeds() {
  std::vector<Deed> deeds;
  for (std::size_t i = 0; i < std::size(deed_names); ++i) deeds.push_back(Deed(i));
  return deeds;
}

RC_GTEST_PROP(Histories, AnyEditsUnderAnyPolicyEndInTheSceneBuiltAnew, ()) {
  Edited edited;
  edited.setup = policies()[*rc::gen::inRange<std::size_t>(0, policies().size())];
  // Long enough for trees to age, short enough to be run a hundred times under sanitizers.
  const std::vector<Edit> history = *histories(all_deeds(), 14);
  edited.apply({Deed::add, history.size()});
  RC_ASSERT(edited.flaw() == "");
  for (const Edit& edit : history) {
    edited.apply(edit);
    RC_ASSERT(edited.flaw() == "");
  }
}

RC_GTEST_PROP(Histories, WhatLeavesTheViewAndEntersItAgainIsAsBuiltAnew, ()) {
  Edited edited;
  edited.setup = *rc::gen::elementOf(two_level_policies());
  const std::vector<Edit> history =
      *histories({Deed::deform, Deed::deform, Deed::deform, Deed::move, Deed::look_elsewhere}, 20);
  for (const std::uint64_t seed : {0, 1, 2}) edited.apply({Deed::add, seed + 3 * history.size()});
  edited.apply({Deed::look_elsewhere, history.size()});
  for (const Edit& edit : history) {
    RC_ASSERT(edited.flaw() == "");
    edited.apply(edit);
  }
  RC_ASSERT(edited.flaw() == "");
}

}  // namespace
}  // namespace regraft::test
