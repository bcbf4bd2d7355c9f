#include "regraft/core/executor.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace regraft {

namespace {

using ChunkBody = std::function<void(std::size_t)>;

/// How long a thread stays awake for what comes next before it sleeps. Longer than the gap
/// between two loops of one update, shorter than anything a user would see as load.
constexpr std::chrono::microseconds spin_time{40};

/// True on a thread that runs a body: loops inside loops run on that thread alone.
thread_local bool inside_body = false;

/// Yields, rather than pauses: on a full machine the core goes to whoever has work.
template <typename Condition>
void spin_until(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + spin_time;
  while (!condition() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

/// While it lives, the thread counts as running a body.
class BodyScope {
 public:
  BodyScope() : before_(inside_body) { inside_body = true; }
  ~BodyScope() { inside_body = before_; }
  BodyScope(const BodyScope&) = delete;
  BodyScope& operator=(const BodyScope&) = delete;

 private:
  bool before_;
};

/// One loop: which chunks are taken, and the exception of the lowest chunk that threw. Chunks
/// are taken in order, so a lower one has always been taken too: the exception is deterministic.
class Job {
 public:
  Job(std::size_t chunk_count, const ChunkBody& body) : count_(chunk_count), body_(&body) {}

  void run() {
    const BodyScope scope;
    for (std::size_t i = next_.fetch_add(1); i < count_; i = next_.fetch_add(1)) {
      try {
        (*body_)(i);
      } catch (...) {
        stop();
        keep(i, std::current_exception());
      }
    }
  }

  /// Hands out no further chunk. @return true if all had been handed out before.
  bool stop() { return next_.exchange(count_) >= count_; }
  bool exhausted() const { return next_.load() >= count_; }
  /// To be called when no thread is inside any more.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  void keep(std::size_t chunk, const std::exception_ptr& error) {
    const std::lock_guard lock(error_mutex_);
    if (chunk >= error_chunk_) return;
    error_chunk_ = chunk;
    error_ = error;
  }

  const std::size_t count_;
  const ChunkBody* body_;
  std::atomic<std::size_t> next_{0};
  std::mutex error_mutex_;
  std::size_t error_chunk_ = std::numeric_limits<std::size_t>::max();
  std::exception_ptr error_;
};

}  // namespace

/// `threads` sleeping workers: `threads - 1` join a plain loop beside its caller, all of them a
/// polled one. A loop never waits for a worker that has not woken up yet.
struct Executor::Pool {
  ~Pool();
  void start(unsigned threads);
  void open(Job& job, unsigned seats);
  void close();
  bool supervise(Job& job, const std::function<bool()>& poll, std::chrono::milliseconds period);

  /// False if another thread's loop is using the pool.
  bool acquire() { return !busy.exchange(true); }
  void release() { busy.store(false); }

  void worker();
  Job* next_job(std::uint64_t& seen, bool was_working);
  void leave_job();

  std::vector<std::thread> workers;
  std::atomic<bool> busy{false};

  std::mutex mutex;
  std::condition_variable wake;  ///< workers wait here for a loop
  std::condition_variable idle;  ///< the caller waits here for the last worker to leave
  // Written under the mutex; the atomics are also watched without it.
  Job* current = nullptr;
  unsigned seats_free = 0;  ///< how many more workers may join `current`
  unsigned spinning = 0;    ///< workers that look for a loop without having to be woken
  std::atomic<bool> stopping{false};
  std::atomic<std::uint64_t> opened{0};  ///< loops so far
  std::atomic<unsigned> inside{0};       ///< workers in `current`
};

Executor::Pool::~Pool() {
  {
    const std::lock_guard lock(mutex);
    stopping.store(true);
    opened.fetch_add(1);
  }
  wake.notify_all();
  for (std::thread& thread : workers) thread.join();
}

void Executor::Pool::start(unsigned threads) {
  workers.reserve(threads);
  for (unsigned i = 0; i < threads; ++i) workers.emplace_back([this] { worker(); });
}

void Executor::Pool::open(Job& job, unsigned seats) {
  unsigned sleepers = 0;
  {
    const std::lock_guard lock(mutex);
    current = &job;
    seats_free = seats;
    sleepers = seats - std::min(seats, spinning);
    opened.fetch_add(1);
  }
  for (unsigned i = 0; i < sleepers; ++i) wake.notify_one();
}

/// No worker may join any more; returns when the last one has left.
void Executor::Pool::close() {
  std::unique_lock lock(mutex);
  seats_free = 0;
  if (inside.load() == 0) return;
  lock.unlock();
  spin_until([this] { return inside.load() == 0; });
  lock.lock();
  idle.wait(lock, [this] { return inside.load() == 0; });
}

/// Polls until `job` is done or `poll` says no. @return true if every chunk was handed out.
bool Executor::Pool::supervise(Job& job, const std::function<bool()>& poll,
                               std::chrono::milliseconds period) {
  const auto done = [&] { return job.exhausted() && inside.load() == 0; };
  std::unique_lock lock(mutex);
  while (!idle.wait_for(lock, period, done)) {
    lock.unlock();
    if (!poll()) return job.stop();
    lock.lock();
  }
  return true;
}

void Executor::Pool::worker() {
  std::uint64_t seen = 0;
  bool was_working = false;
  for (;;) {
    const std::uint64_t before = seen;
    if (was_working) spin_until([&] { return opened.load() != before; });
    Job* job = next_job(seen, was_working);
    if (stopping.load()) return;
    was_working = job != nullptr;
    if (job == nullptr) continue;
    job->run();
    leave_job();
  }
}

/// Sleeps until there is a loop newer than `seen`; null if it has no seat left. A worker without
/// a seat does not spin afterwards: the pool has more workers than most loops want.
Job* Executor::Pool::next_job(std::uint64_t& seen, bool was_working) {
  std::unique_lock lock(mutex);
  if (was_working) --spinning;
  wake.wait(lock, [&] { return opened.load() != seen; });
  seen = opened.load();
  if (stopping.load() || seats_free == 0) return nullptr;
  --seats_free;
  inside.fetch_add(1);
  return current;
}

void Executor::Pool::leave_job() {
  const std::lock_guard lock(mutex);
  ++spinning;
  if (inside.fetch_sub(1) == 1) idle.notify_all();
}

namespace {

/// All chunks on the calling thread; for loops within loops, and while the pool is busy.
void run_alone(std::size_t chunk_count, const ChunkBody& body) {
  const BodyScope scope;
  for (std::size_t i = 0; i < chunk_count; ++i) body(i);
}

/// As `run_alone`, polling between chunks.
bool run_alone_polled(std::size_t chunk_count, const ChunkBody& body,
                      const std::function<bool()>& poll, std::chrono::milliseconds period) {
  auto polled = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < chunk_count; ++i) {
    const auto now = std::chrono::steady_clock::now();
    if (now - polled >= period) {
      polled = now;
      if (!poll()) return false;
    }
    const BodyScope scope;
    body(i);
  }
  return true;
}

}  // namespace

Executor::Executor(unsigned threads) : pool_(std::make_unique<Pool>()) {
  pool_->start(threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency()));
}

Executor::~Executor() = default;

unsigned Executor::threads() const {
  return static_cast<unsigned>(pool_->workers.size());
}

void Executor::parallel_for(std::size_t count, std::size_t grain,
                            const std::function<void(std::size_t, std::size_t)>& body) {
  const std::size_t step = std::max<std::size_t>(1, grain);
  const std::size_t chunk_count = count / step + (count % step != 0);
  const ChunkBody chunk = [&](std::size_t i) {
    body(i * step, i * step + std::min(step, count - i * step));
  };
  if (chunk_count == 1) return body(0, count);
  if (chunk_count == 0 || threads() == 1 || inside_body || !pool_->acquire()) {
    run_alone(chunk_count, chunk);
    return;
  }
  Job job(chunk_count, chunk);
  pool_->open(job, static_cast<unsigned>(std::min<std::size_t>(threads() - 1, chunk_count - 1)));
  job.run();
  pool_->close();
  pool_->release();
  job.rethrow();
}

bool Executor::parallel_for_polled(std::size_t count, const ChunkBody& body,
                                   const std::function<bool()>& poll, unsigned poll_ms) {
  const std::chrono::milliseconds period(poll_ms);
  if (!poll()) return count == 0;
  if (inside_body || !pool_->acquire()) return run_alone_polled(count, body, poll, period);
  Job job(count, body);
  bool handed_out = false;
  std::exception_ptr poll_error;
  pool_->open(job, static_cast<unsigned>(std::min<std::size_t>(threads(), count)));
  try {
    handed_out = pool_->supervise(job, poll, period);
  } catch (...) {
    poll_error = std::current_exception();
    job.stop();
  }
  pool_->close();
  pool_->release();
  if (poll_error) std::rethrow_exception(poll_error);
  job.rethrow();
  return handed_out;
}

}  // namespace regraft
