#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "brim/core/parallel.h"

namespace brim {

/// Reusable scratch memory for const functions that may run on several threads at once: each call borrows one
/// workspace and gives it back, so that memory is allocated once per simultaneous call, not once per call.
template <class Workspace>
class WorkspacePool {
 public:
  /// Holds a workspace for as long as it lives.
  class Loan {
   public:
    explicit Loan(WorkspacePool& pool) : pool_(pool), workspace_(pool.take()) {}
    ~Loan() { pool_.give_back(std::move(workspace_)); }
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    Workspace& operator*() { return *workspace_; }
    Workspace* operator->() { return workspace_.get(); }

   private:
    WorkspacePool& pool_;
    std::unique_ptr<Workspace> workspace_;
  };

  WorkspacePool() = default;
  ~WorkspacePool() {
    for (Place& p : place_) delete p.workspace.load();
  }
  WorkspacePool(const WorkspacePool&) = delete;
  WorkspacePool& operator=(const WorkspacePool&) = delete;

  Loan borrow() { return Loan(*this); }

 private:
  /// Slot in which a thread leaves the workspace it will need again; another thread may take it.
  struct alignas(64) Place {
    std::atomic<Workspace*> workspace{nullptr};
  };
  std::atomic<Workspace*>& own_place() { return place_[static_cast<std::size_t>(thread_number()) % kPlaces].workspace; }

  std::unique_ptr<Workspace> take() {
    if (Workspace* own = own_place().exchange(nullptr, std::memory_order_acquire))
      return std::unique_ptr<Workspace>(own);
    for (Place& p : place_)
      if (p.workspace.load(std::memory_order_relaxed) != nullptr)
        if (Workspace* left = p.workspace.exchange(nullptr, std::memory_order_acquire))
          return std::unique_ptr<Workspace>(left);
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<Workspace>();
    auto workspace = std::move(free_.back());
    free_.pop_back();
    return workspace;
  }
  void give_back(std::unique_ptr<Workspace> workspace) {
    Workspace* nothing = nullptr;
    if (own_place().compare_exchange_strong(nothing, workspace.get(), std::memory_order_release)) {
      static_cast<void>(workspace.release());  // own_place() has it now
      return;
    }
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(workspace));
  }

  static constexpr std::size_t kPlaces = 16;
  std::array<Place, kPlaces> place_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Workspace>> free_;
};

}  // namespace brim
