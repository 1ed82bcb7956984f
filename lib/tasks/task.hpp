// SPDX-License-Identifier: GPL-3.0-or-later
// MotionTask: a computation that stops where it wants forcing periods carried (TaskPool), and goes on when they are. It is
// written as if its motion were alone: a coroutine, which another of its kind may wait for.
#pragma once

#include <coroutine>
#include <exception>
#include <optional>
#include <utility>

namespace graze {

template <class T = void> class MotionTask;

/// What a MotionTask leaves behind.
struct LanePromiseBase {
  std::exception_ptr error;
  std::coroutine_handle<> waiting = std::noop_coroutine();  ///< goes on at its end

  struct HandBack {
    bool await_ready() const noexcept { return false; }
    template <class Promise> std::coroutine_handle<> await_suspend(std::coroutine_handle<Promise> ended) const noexcept {
      return ended.promise().waiting;
    }
    void await_resume() const noexcept {}
  };
  std::suspend_always initial_suspend() const noexcept { return {}; }
  HandBack final_suspend() const noexcept { return {}; }
  void unhandled_exception() { error = std::current_exception(); }
};

template <class T> struct LanePromise : LanePromiseBase {
  std::optional<T> value;
  MotionTask<T> get_return_object();
  void return_value(T result) { value = std::move(result); }
  T result() {
    if (error) std::rethrow_exception(error);
    return std::move(*value);
  }
};

template <> struct LanePromise<void> : LanePromiseBase {
  MotionTask<void> get_return_object();
  void return_void() const {}
  void result() const {
    if (error) std::rethrow_exception(error);
  }
};

/// What it is given by reference has to outlive it. (An aggregate made among the arguments of what is awaited, f({a, b}), g++ 12
/// destroys twice: give it a name.)
template <class T> class [[nodiscard]] MotionTask {
 public:
  using promise_type = LanePromise<T>;
  using Handle = std::coroutine_handle<promise_type>;

  MotionTask() = default;
  explicit MotionTask(Handle handle) : handle_(handle) {}
  MotionTask(MotionTask&& other) noexcept : handle_(std::exchange(other.handle_, {})) {}
  MotionTask& operator=(MotionTask&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~MotionTask() {
    if (handle_) handle_.destroy();
  }

  /// From its beginning to where it first stops.
  void begin() { handle_.resume(); }
  bool ended() const { return handle_.done(); }
  /// Of one that has ended. @throws what it threw.
  T result() { return handle_.promise().result(); }

  bool await_ready() const noexcept { return false; }
  std::coroutine_handle<> await_suspend(std::coroutine_handle<> waiting) noexcept {
    handle_.promise().waiting = waiting;
    return handle_;
  }
  T await_resume() { return result(); }

 private:
  Handle handle_ = {};
};

template <class T> MotionTask<T> LanePromise<T>::get_return_object() {
  return MotionTask<T>(std::coroutine_handle<LanePromise>::from_promise(*this));
}
inline MotionTask<void> LanePromise<void>::get_return_object() {
  return MotionTask<void>(std::coroutine_handle<LanePromise>::from_promise(*this));
}

}  // namespace graze
