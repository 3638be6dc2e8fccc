#pragma once

#include <sys/types.h>

#include <string>

namespace brim::cli {

/// `brim view` of a run that is being made, in a process of its own: HDF5 does not read and write one file in two
/// threads. It prints its address, and ends with this object or with this process, whichever goes first.
class LiveView {
 public:
  /// @param folder        of the run; its first frame is on disk
  /// @param out_to_error  keeps standard output for others
  /// @param hand          socket that it sends what pages ask of the bodies to (Hand); -1: pages can ask nothing
  /// @throws InputError   when the process cannot be started
  LiveView(const std::string& folder, bool out_to_error, int hand = -1);
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// Waits for Ctrl-C, or for the view's own end.
  void stay();

 private:
  bool alive();
  pid_t child_ = 0;
};

}  // namespace brim::cli
