// Steps of a session's world, edits, and the arrays that show its state.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "arrays.h"
#include "brim/core/stop.h"
#include "brim/world/report_fields.h"
#include "interpreter_lock.h"
#include "session.h"
#include "session_busy.h"

namespace brim::python {

namespace {

/// Time between two looks at Python's signals.
constexpr std::chrono::milliseconds kLook(50);

}  // namespace

void Session::edit(const std::function<void()>& change) {
  const Busy busy(*this);
  read_mirrors();
  unlocked(change);
  fill_mirrors();
}

void Session::unlocked(const std::function<void()>& f) {
  if (served_) {
    caller_->run(f);
    return;
  }
  const Unlocked unlocked;
  f();
}

World& Session::world() {
  if (busy_) {
    PyErr_SetString(PyExc_RuntimeError, "the world is in the middle of a step");
    throw py::error_already_set();
  }
  read_mirrors();
  return *world_;
}

Session::Mirror& Session::mirror(int body) {
  auto& m = mirrors_.at(static_cast<std::size_t>(body));
  if (!m) {
    const Busy busy(*this);
    m = std::make_unique<Mirror>();
    const auto q = world_->q(body), v = world_->v(body);
    m->q.assign(q.begin(), q.end());
    m->v.assign(v.begin(), v.end());
    m->removed = world_->removed(body);
  }
  return *m;
}

void Session::read_mirrors() {
  std::vector<int> written;
  const auto differs = [](std::span<const double> a, const std::vector<double>& b) {
    return !b.empty() && std::memcmp(a.data(), b.data(), b.size() * sizeof(double)) != 0;
  };
  const auto check = [&](int body, const char* what, const std::vector<double>& x) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!std::isfinite(x[i]))
        throw InputError(fmt::format("{}[{}] of body \"{}\" is not finite", what, i, world_->body(body).name()));
  };
  for (int b = 0; b < static_cast<int>(mirrors_.size()); ++b) {
    const auto& m = mirrors_[static_cast<std::size_t>(b)];
    if (!m || (!differs(world_->q(b), m->q) && !differs(world_->v(b), m->v))) continue;
    check(b, "q", m->q), check(b, "v", m->v);
    written.push_back(b);
  }
  if (written.empty()) return;
  State state = world_->state();
  std::size_t q0 = 0, v0 = 0;
  for (int b = 0; b < world_->body_count(); ++b) {
    const auto& m = mirrors_[static_cast<std::size_t>(b)];
    if (m) {
      std::copy(m->q.begin(), m->q.end(), state.q.begin() + static_cast<std::ptrdiff_t>(q0));
      std::copy(m->v.begin(), m->v.end(), state.v.begin() + static_cast<std::ptrdiff_t>(v0));
    }
    q0 += world_->q(b).size(), v0 += world_->v(b).size();
  }
  unlocked([&] { world_->set_state(std::move(state)); });
  if (world_->options().sleep)
    for (const int b : written) world_->wake(b);
  // What is frozen or removed takes no velocity.
  for (const int b : written) {
    const auto v = world_->v(b);
    std::copy(v.begin(), v.end(), mirrors_[static_cast<std::size_t>(b)]->v.begin());
  }
}

/// Forces on bodies, for as long as it lives.
struct Session::Acting {
  Acting(Session& s, const std::map<int, py::object>& forces) : session(s) {
    std::map<int, std::vector<double>> checked;
    for (const auto& [b, Q] : forces) {
      if (!s.takes_forces(b)) throw InputError(fmt::format("body \"{}\" takes no forces", s.world_->body(b).name()));
      checked[b] = numbers_of(Q, s.world_->v(b).size(), fmt::format("force on body \"{}\"", s.world_->body(b).name()));
    }
    for (auto& [b, Q] : checked) {
      if (s.world_->options().sleep && std::any_of(Q.begin(), Q.end(), [](double f) { return f != 0.0; }))
        s.world_->wake(b);
      session.outer_[static_cast<std::size_t>(b)]->set_outer_forces(std::move(Q));
      bodies.push_back(b);
    }
  }
  ~Acting() {
    for (const int b : bodies) session.outer_[static_cast<std::size_t>(b)]->set_outer_forces({});
  }
  Session& session;
  std::vector<int> bodies;
};

void Session::fill_mirrors() {
  for (int b = 0; b < static_cast<int>(mirrors_.size()); ++b) {
    const auto& m = mirrors_[static_cast<std::size_t>(b)];
    if (!m) continue;
    std::copy(world_->q(b).begin(), world_->q(b).end(), m->q.begin());
    std::copy(world_->v(b).begin(), world_->v(b).end(), m->v.begin());
    m->removed = world_->removed(b);
  }
}

void Session::step(bool joined, const std::map<int, py::object>& forces) {
  const Busy busy(*this);
  const Acting acting(*this, forces);
  read_mirrors();
  const State before = world_->state();
  StepReport report;
  // Python's signals are seen between sub-steps, iterations and sweeps: Ctrl-C ends a long step.
  std::exception_ptr interrupt;
  auto looked = std::chrono::steady_clock::now();
  const StopScope::Asked ends = [&, asker = std::this_thread::get_id()] {
    if (interpreter_ends(asker)) return true;
    const auto now = std::chrono::steady_clock::now();
    if (now - looked < kLook) return false;
    looked = now;
    const Locked lock;
    if (PyErr_CheckSignals() == 0) return false;
    interrupt = std::make_exception_ptr(py::error_already_set());
    return true;
  };
  try {
    unlocked([&] {
      const StopScope scope(ends);
      report = world_->step();
    });
  } catch (...) {
    const std::exception_ptr thrown = std::current_exception();
    try {
      unlocked([&] { world_->set_state(before); });
    } catch (...) {
      // The state is put back all the same; bodies that raised again take it in at the next step.
    }
    std::rethrow_exception(interrupt ? interrupt : thrown);
  }
  fill_mirrors();
  if (joined)
    accumulate(report_, std::move(report));
  else
    report_ = std::move(report);
}

State Session::state() { return world().state(); }

void Session::set_state(State state) {
  const Busy busy(*this);
  unlocked([&] { world_->set_state(std::move(state)); });
  fill_mirrors();
  report_ = StepReport{};
}

}  // namespace brim::python
