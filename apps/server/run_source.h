#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "server/density_slice.h"

namespace brim::viewer {

/// How far a run has come.
struct Progress {
  std::int64_t frames = 0;
  bool complete = false;  ///< no more frames are to be expected
  bool stopped = false;   ///< and that is because the writer is gone without having ended the run
  bool operator==(const Progress&) const = default;
};

/// So much is asked for at once that this must wait.
class Busy : public InputError {
 public:
  using InputError::InputError;
};

/// What the server shows. Functions may be called from several threads at once; they throw InputError for what is not
/// there or cannot be read. Messages are those of ArrayMessage; docs/viewer.md lists their arrays.
class RunSource {
 public:
  virtual ~RunSource() = default;
  virtual Progress progress() = 0;
  virtual nlohmann::json info() = 0;
  virtual std::string topology(int body) = 0;
  virtual std::string frame(std::int64_t frame) = 0;
  /// Densities on a plane at a frame. @throws TooMuchWork, Busy
  virtual std::string slice(std::int64_t frame, const SliceRequest& request) = 0;
  /// Von Mises stress of elastic solids at a frame, [Pa] at the vertices of their displays. @throws Busy
  virtual std::string stress(std::int64_t frame) = 0;
  /// Every recorded scalar from a frame on.
  virtual std::string series(std::int64_t from) = 0;
};

}  // namespace brim::viewer
