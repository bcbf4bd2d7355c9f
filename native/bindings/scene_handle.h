#pragma once

#include <mutex>
#include <stdexcept>

#include "regraft/render/renderer.h"

namespace regraft::bindings {

/// What Python holds as `regraft.Scene`: the renderer, and who is using it just now. The counts
/// are touched with the GIL held only.
struct SceneHandle {
  SceneHandle(unsigned threads, simd::Isa isa) : renderer(threads, isa) {}

  render::Renderer renderer;
  int readers = 0;
  bool updating = false;
  /// One picture at a time; recursive, since a progress callback may ask for another. Taken
  /// without the GIL.
  std::recursive_mutex rendering;
};

/// Held round a call that traces. Throws if the scene is being updated by another thread, or has
/// changed since its last update.
class Tracing {
 public:
  explicit Tracing(SceneHandle& handle) : handle_(handle), tracer_(usable(handle).tracer()) {
    ++handle_.readers;
  }
  ~Tracing() { --handle_.readers; }
  Tracing(const Tracing&) = delete;
  Tracing& operator=(const Tracing&) = delete;

  const trace::Tracer& tracer() const { return tracer_; }

 private:
  static const render::Renderer& usable(const SceneHandle& handle) {
    if (handle.updating) throw std::runtime_error("the scene is being updated by another thread");
    return handle.renderer;
  }

  SceneHandle& handle_;
  trace::Tracer tracer_;
};

/// The scene, to be modified now. Throws while another call, or the one whose callback this is,
/// has it.
inline Scene& modifiable(SceneHandle& handle) {
  if (handle.readers != 0) {
    throw std::runtime_error("the scene is being traced; change it when that call has returned");
  }
  if (handle.updating) throw std::runtime_error("the scene is being updated by another thread");
  return handle.renderer.scene();
}

/// Held round an update.
class Updating {
 public:
  explicit Updating(SceneHandle& handle) : handle_(handle) {
    modifiable(handle);
    handle_.updating = true;
  }
  ~Updating() { handle_.updating = false; }
  Updating(const Updating&) = delete;
  Updating& operator=(const Updating&) = delete;

 private:
  SceneHandle& handle_;
};

}  // namespace regraft::bindings
