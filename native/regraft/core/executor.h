#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace regraft {

/// A small persistent thread pool. Why our own: a shared TBB inside Blender's process mixes
/// versions, and Taskflow is in no registry we may use.
///
/// Work is handed out by index, so what is computed never depends on who computes it.
class Executor {
 public:
  /// `threads` counts the calling thread; 0 takes every core.
  explicit Executor(unsigned threads = 0);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  unsigned threads() const;

  /// Calls `body(begin, end)` over [0, count) in chunks of at most `grain`, on all threads, and
  /// returns when all are done. After an exception no further chunk is begun, and that of the
  /// lowest chunk is rethrown here. Called from inside a body, or while another thread uses the
  /// pool, it runs on the calling thread alone; a loop of one chunk leaves the pool to the loops
  /// inside it.
  void parallel_for(std::size_t count, std::size_t grain,
                    const std::function<void(std::size_t, std::size_t)>& body);

  /// As `parallel_for` with chunks of 1, but the calling thread does no work: it calls `poll`
  /// first of all and then about every `poll_ms` milliseconds until all chunks are done. `poll`
  /// returning false, or throwing, asks the pool to hand out no further chunk.
  /// @return true when every chunk was handed out.
  bool parallel_for_polled(std::size_t count, const std::function<void(std::size_t)>& body,
                           const std::function<bool()>& poll, unsigned poll_ms = 20);

 private:
  struct Pool;
  std::unique_ptr<Pool> pool_;
};

}  // namespace regraft
