#include "regraft/core/executor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace regraft {
namespace {

bool always() {
  return true;
}

class ExecutorTest : public testing::TestWithParam<unsigned> {
 protected:
  Executor executor{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Threads, ExecutorTest, testing::Values(1u, 2u, 3u, 8u),
                         testing::PrintToStringParamName());

TEST(Executor, ZeroThreadsTakesEveryCore) {
  EXPECT_EQ(Executor(0).threads(), std::max(1u, std::thread::hardware_concurrency()));
}

TEST(Executor, ThreadsCountsTheCaller) {
  EXPECT_EQ(Executor(3).threads(), 3u);
}

TEST_P(ExecutorTest, ParallelForVisitsEveryIndexOnceInChunksOfTheGrain) {
  for (const std::size_t count : {0u, 1u, 7u, 64u, 1000u}) {
    std::vector<std::atomic<int>> visits(count);
    executor.parallel_for(count, 7, [&](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin % 7, 0u);
      EXPECT_LE(end - begin, 7u);
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    for (const auto& v : visits) EXPECT_EQ(v, 1);
  }
}

TEST_P(ExecutorTest, ParallelForTreatsAGrainOfZeroAsOne) {
  std::atomic<int> chunks{0};
  executor.parallel_for(5, 0, [&](std::size_t, std::size_t) { ++chunks; });
  EXPECT_EQ(chunks, 5);
}

TEST_P(ExecutorTest, ParallelForNeverUsesMoreThreadsThanAskedFor) {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  for (int round = 0; round < 50; ++round) {
    ids.clear();
    executor.parallel_for(64, 1, [&](std::size_t, std::size_t) {
      const std::lock_guard lock(mutex);
      ids.insert(std::this_thread::get_id());
    });
    EXPECT_LE(ids.size(), GetParam());
  }
}

TEST(Executor, ParallelForLetsTwoThreadsWorkAtTheSameTime) {
  Executor executor(2);
  std::atomic<int> arrived{0};
  executor.parallel_for(2, 1, [&](std::size_t, std::size_t) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
  });
  EXPECT_EQ(arrived, 2);
}

TEST_P(ExecutorTest, ParallelForRethrowsTheExceptionOfTheLowestChunk) {
  for (int round = 0; round < 200; ++round) {
    try {
      executor.parallel_for(100, 1, [](std::size_t i, std::size_t) {
        if (i >= 5) throw std::runtime_error(std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "5");
    }
  }
}

TEST_P(ExecutorTest, ParallelForBeginsNoChunkAfterAnException) {
  std::atomic<int> begun{0};
  EXPECT_THROW(executor.parallel_for(100000, 1,
                                     [&](std::size_t, std::size_t) {
                                       ++begun;
                                       throw std::runtime_error("stop");
                                     }),
               std::runtime_error);
  EXPECT_LE(begun, static_cast<int>(GetParam()));
}

TEST_P(ExecutorTest, IsUsableAfterAnException) {
  EXPECT_THROW(
      executor.parallel_for(9, 1, [](std::size_t, std::size_t) { throw std::logic_error(""); }),
      std::logic_error);
  std::atomic<int> sum{0};
  executor.parallel_for(9, 1, [&](std::size_t i, std::size_t) { sum += static_cast<int>(i); });
  EXPECT_EQ(sum, 36);
}

TEST_P(ExecutorTest, ALoopInsideALoopRunsOnItsThreadAlone) {
  std::atomic<int> strangers{0};
  std::atomic<int> visits{0};
  executor.parallel_for(8, 1, [&](std::size_t, std::size_t) {
    const auto self = std::this_thread::get_id();
    executor.parallel_for(8, 1, [&](std::size_t, std::size_t) {
      ++visits;
      if (std::this_thread::get_id() != self) ++strangers;
    });
  });
  EXPECT_EQ(visits, 64);
  EXPECT_EQ(strangers, 0);
}

TEST(Executor, ALoopInsideALoopOfOneChunkUsesThePool) {
  Executor executor(2);
  std::atomic<int> arrived{0};
  executor.parallel_for(1, 1, [&](std::size_t, std::size_t) {
    executor.parallel_for(2, 1, [&](std::size_t, std::size_t) {
      ++arrived;
      while (arrived < 2) std::this_thread::yield();
    });
  });
  EXPECT_EQ(arrived, 2);
}

TEST_P(ExecutorTest, TwoCallersShareThePoolWithoutWaitingForEachOther) {
  std::atomic<std::size_t> sum{0};
  const auto caller = [&] {
    for (int round = 0; round < 200; ++round) {
      executor.parallel_for(32, 4, [&](std::size_t begin, std::size_t end) { sum += end - begin; });
    }
  };
  std::thread other(caller);
  caller();
  other.join();
  EXPECT_EQ(sum, 2u * 200u * 32u);
}

TEST_P(ExecutorTest, ManySmallLoopsInARowAreAllComplete) {
  std::vector<std::size_t> values(16);
  for (std::size_t round = 1; round <= 5000; ++round) {
    executor.parallel_for(values.size(), 1, [&](std::size_t i, std::size_t) { ++values[i]; });
    if (round % 500 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  for (const std::size_t v : values) EXPECT_EQ(v, 5000u);
}

TEST_P(ExecutorTest, PolledVisitsEveryIndexOnce) {
  std::vector<std::atomic<int>> visits(300);
  EXPECT_TRUE(executor.parallel_for_polled(
      visits.size(), [&](std::size_t i) { ++visits[i]; }, always));
  for (const auto& v : visits) EXPECT_EQ(v, 1);
}

TEST_P(ExecutorTest, PolledOverNothingIsComplete) {
  EXPECT_TRUE(executor.parallel_for_polled(
      0, [](std::size_t) { FAIL(); }, always));
}

TEST_P(ExecutorTest, PolledLeavesTheCallingThreadFree) {
  const auto caller = std::this_thread::get_id();
  std::atomic<int> at_caller{0};
  executor.parallel_for_polled(
      50, [&](std::size_t) { at_caller += std::this_thread::get_id() == caller; }, always);
  EXPECT_EQ(at_caller, 0);
}

TEST_P(ExecutorTest, PollRunsOnTheCallingThreadWhileWorkIsGoingOn) {
  const auto caller = std::this_thread::get_id();
  std::atomic<bool> polled{false};
  int polls = 0;
  executor.parallel_for_polled(
      1,
      [&](std::size_t) {
        while (!polled) std::this_thread::yield();
      },
      [&] {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        polled = ++polls > 2;
        return true;
      },
      1);
  EXPECT_GT(polls, 2);
}

TEST_P(ExecutorTest, PollRefusingAtOnceMeansNoWork) {
  EXPECT_FALSE(executor.parallel_for_polled(
      9, [](std::size_t) { FAIL(); }, [] { return false; }));
}

TEST_P(ExecutorTest, PollRefusingStopsTheHandingOutOfChunks) {
  std::atomic<bool> refused{false};
  std::atomic<std::size_t> begun{0};
  int polls = 0;
  const bool complete = executor.parallel_for_polled(
      1000,
      [&](std::size_t) {
        ++begun;
        while (!refused) std::this_thread::yield();
      },
      [&] {
        refused = ++polls > 1;
        return !refused;
      },
      1);
  EXPECT_FALSE(complete);
  EXPECT_LT(begun, 1000u);
}

TEST_P(ExecutorTest, PolledRethrowsWhatABodyThrows) {
  EXPECT_THROW(executor.parallel_for_polled(
                   20,
                   [](std::size_t i) {
                     if (i == 3) throw std::runtime_error("");
                   },
                   always),
               std::runtime_error);
}

TEST_P(ExecutorTest, PolledRethrowsWhatPollThrowsAfterTheWorkersHaveStopped) {
  std::atomic<bool> thrown{false};
  std::atomic<int> running{0};
  int polls = 0;
  EXPECT_THROW(executor.parallel_for_polled(
                   100,
                   [&](std::size_t) {
                     ++running;
                     while (!thrown) std::this_thread::yield();
                     --running;
                   },
                   [&]() -> bool {
                     if (++polls < 3) return true;
                     thrown = true;
                     throw std::runtime_error("poll");
                   },
                   1),
               std::runtime_error);
  EXPECT_EQ(running, 0);
}

TEST(Executor, PolledUsesAsManyWorkersAsThreads) {
  Executor executor(2);
  std::atomic<int> arrived{0};
  executor.parallel_for_polled(
      2,
      [&](std::size_t) {
        ++arrived;
        while (arrived < 2) std::this_thread::yield();
      },
      always);
  EXPECT_EQ(arrived, 2);
}

TEST_P(ExecutorTest, PolledInsideABodyStillPollsAndCompletes) {
  std::atomic<int> visits{0};
  executor.parallel_for(4, 1, [&](std::size_t, std::size_t) {
    EXPECT_TRUE(executor.parallel_for_polled(
        10, [&](std::size_t) { ++visits; }, always, 0));
  });
  EXPECT_EQ(visits, 40);
}

TEST(Executor, PolledInsideABodyCanBeStopped) {
  Executor executor(1);
  int visits = 0;
  int polls = 0;
  executor.parallel_for(2, 1, [&](std::size_t, std::size_t) {
    polls = 0;
    EXPECT_FALSE(executor.parallel_for_polled(
        100, [&](std::size_t) { ++visits; }, [&] { return ++polls < 4; }, 0));
  });
  EXPECT_EQ(visits, 2 * 2);
}

TEST(Executor, IsDestroyedCleanlyWhetherItWorkedOrNot) {
  for (int round = 0; round < 30; ++round) {
    Executor executor(3);
    if (round % 2 == 0) executor.parallel_for(8, 1, [](std::size_t, std::size_t) {});
  }
}

}  // namespace
}  // namespace regraft
