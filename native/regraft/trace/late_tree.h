#pragma once

#include <atomic>
#include <cstdint>

namespace regraft::trace {

/// The tree of a mesh that has moved on without it. No ray pays for it until one comes near, as for
/// the cells of a lazy k-d tree (Hunt, Mark, Fussell, RT 2007).
///
/// Not inline: kernels of every instruction set call the same function.
class LateTree {
 public:
  LateTree() = default;
  virtual ~LateTree();
  LateTree(const LateTree&) = delete;
  LateTree& operator=(const LateTree&) = delete;

  /// Returns once the tree has caught up. The first caller sees to that, others wait; if it throws,
  /// the next one tries again. What a view tells of the tree is to be read afterwards only.
  void arrive();
  bool has_arrived() const;

 private:
  enum State : std::uint32_t { behind, catching_up, ready };

  /// Brings the tree and all views of it up to date; called by one thread at a time.
  virtual void catch_up() = 0;
  void leave(State state);

  std::atomic<std::uint32_t> state_{behind};
};

}  // namespace regraft::trace
