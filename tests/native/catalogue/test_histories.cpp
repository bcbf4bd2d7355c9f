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
  keep_otherwise
};
constexpr const char* deed_names[] = {"add",          "instance again", "remove",        "deform",
                                      "retopologise", "hide or show",   "move",          "teleport",
                                      "squash",       "mend",           "keep otherwise"};

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
    const std::vector<Ray> rays = nasty_rays(SceneOracle(scene_), ++updates_, 12);
    return difference(accelerator_.view(), width_, rays, hits_anew(scene_, rays));
  }

  Setup setup{accel::Policy::automatic, accel::Layout::two_level};

 private:
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
  std::vector<std::uint32_t> instances_;
};

rc::Gen<std::vector<Edit>> histories() {
  const auto deed =
      rc::gen::map(rc::gen::inRange(0, int(std::size(deed_names))), [](int i) { return Deed(i); });
  const auto edit = rc::gen::construct<Edit>(deed, rc::gen::arbitrary<std::uint64_t>());
  // Long enough for trees to age, short enough to be run a hundred times under sanitizers.
  return rc::gen::resize(14, rc::gen::container<std::vector<Edit>>(edit));
}

RC_GTEST_PROP(Histories, AnyEditsUnderAnyPolicyEndInTheSceneBuiltAnew, ()) {
  Edited edited;
  edited.setup = policies()[*rc::gen::inRange<std::size_t>(0, policies().size())];
  const std::vector<Edit> history = *histories();
  edited.apply({Deed::add, history.size()});
  RC_ASSERT(edited.flaw() == "");
  for (const Edit& edit : history) {
    edited.apply(edit);
    RC_ASSERT(edited.flaw() == "");
  }
}

}  // namespace
}  // namespace regraft::test
