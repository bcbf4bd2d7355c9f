#pragma once

// Scenes and shots that the command has written down for measuring programs.

#include <fstream>
#include <stdexcept>
#include <vector>

namespace regraft::bench {

/// Reads numbers as they lie in memory, one after the other.
class BinaryFile {
 public:
  explicit BinaryFile(const char* path) : in_(path, std::ios::binary) {}

  template <class T>
  T one() {
    return many<T>(1).front();
  }
  template <class T>
  std::vector<T> many(std::size_t count) {
    std::vector<T> values(count);
    in_.read(reinterpret_cast<char*>(values.data()), std::streamsize(count * sizeof(T)));
    if (!in_) throw std::runtime_error("the file is cut short or cannot be read");
    return values;
  }

 private:
  std::ifstream in_;
};

}  // namespace regraft::bench
