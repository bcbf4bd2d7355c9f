#pragma once

#include <cmath>
#include <vector>

#include "bvh/boxes.h"

namespace regraft::test {

/// What makes builders loop, dive or blow up.
struct Trap {
  const char* name;
  Boxes boxes;
};

inline std::vector<Trap> traps() {
  std::vector<Trap> list;
  std::vector<Aabb> geometric, huge, denormal, wires, points, far, mixed;
  for (int i = 0; i < 250; ++i) {
    const double x = std::ldexp(1.0, i % 250 - 126);
    geometric.push_back(cube({x, 0, 0}, x / 4));
    huge.push_back(cube({i % 2 == 0 ? 3e38 : -3e38, 1e38 * (i % 3), double(i)}, 1e37));
    denormal.push_back(cube({1e-40 * i, -1e-42 * i, 1e-45 * i}, 1e-41));
    wires.push_back({Vec3(0, float(i), 0), Vec3(1e8f, float(i), 0)});
    points.push_back({Vec3(float(i % 7), float(i % 5), 0), Vec3(float(i % 7), float(i % 5), 0)});
    far.push_back(cube({1e9 + i, 1e9, 1e9}, 10.0));
    mixed.push_back(i == 0 ? cube({0, 0, 0}, 1e9) : cube({double(i), 0, 0}, 1e-9));
  }
  list.push_back({"a geometric series", Boxes(geometric)});
  list.push_back({"boxes near the largest float", Boxes(huge)});
  list.push_back({"denormal boxes", Boxes(denormal)});
  list.push_back({"wires", Boxes(wires)});
  list.push_back({"points", Boxes(points)});
  list.push_back({"far away", Boxes(far)});
  list.push_back({"one huge box among dust", Boxes(mixed)});
  list.push_back({"one point", Boxes(std::vector<Aabb>(300, cube({1, 1, 1}, 0.0)))});
  return list;
}

}  // namespace regraft::test
