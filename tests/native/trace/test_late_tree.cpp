#include "regraft/trace/late_tree.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace regraft::test {
namespace {

/// Catches up slowly; fails the first few times.
class Slow final : public trace::LateTree {
 public:
  explicit Slow(int failures) : failures_(failures) {}
  int done = 0;  ///< not atomic: whoever sees it must have arrived
  int tries = 0;

 private:
  void catch_up() override {
    ++tries;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (failures_-- > 0) throw std::runtime_error("not yet");
    ++done;
  }
  int failures_;
};

/// Threads that arrive at once; returns how many of them met an exception.
int arrive_at_once(Slow& tree, int count) {
  std::atomic<int> thrown{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i)
    threads.emplace_back([&] {
      try {
        tree.arrive();
        EXPECT_EQ(tree.done, 1);
      } catch (const std::runtime_error&) {
        ++thrown;
      }
    });
  for (std::thread& thread : threads) thread.join();
  return thrown;
}

TEST(LateTree, OneOfManyThreadsBringsItUpToDateAndAllSeeIt) {
  Slow tree(0);
  EXPECT_FALSE(tree.has_arrived());
  EXPECT_EQ(arrive_at_once(tree, 8), 0);
  EXPECT_TRUE(tree.has_arrived());
  EXPECT_EQ(tree.tries, 1);
}

TEST(LateTree, AfterAFailureTheNextThreadTriesAgain) {
  Slow tree(3);
  EXPECT_EQ(arrive_at_once(tree, 8), 3);
  EXPECT_TRUE(tree.has_arrived());
  EXPECT_EQ(tree.tries, 4);
}

}  // namespace
}  // namespace regraft::test
