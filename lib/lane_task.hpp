// SPDX-License-Identifier: GPL-3.0-or-later
// LaneTask: a computation that stops where it wants forcing periods carried (LanePool), and goes on when they are. It is written
// as if its motion were alone: a coroutine, which another of its kind may wait for.
#pragma once

#include <coroutine>
#include <exception>
#include <optional>
#include <utility>

namespace graze {

template <class T = void> class LaneTask;

/// What a LaneTask leaves behind.
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
  LaneTask<T> get_return_object();
  void return_value(T result) { value = std::move(result); }
  T result() {
    if (error) std::rethrow_exception(error);
    return std::move(*value);
  }
};

template <> struct LanePromise<void> : LanePromiseBase {
  LaneTask<void> get_return_object();
  void return_void() const {}
  void result() const {
    if (error) std::rethrow_exception(error);
  }
};

/// What it is given by reference has to outlive it. (An aggregate made among the arguments of what is awaited, f({a, b}), g++ 12
/// destroys twice: give it a name.)
template <class T> class [[nodiscard]] LaneTask {
 public:
  using promise_type = LanePromise<T>;
  using Handle = std::coroutine_handle<promise_type>;

  LaneTask() = default;
  explicit LaneTask(Handle handle) : handle_(handle) {}
  LaneTask(LaneTask&& other) noexcept : handle_(std::exchange(other.handle_, {})) {}
  LaneTask& operator=(LaneTask&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~LaneTask() {
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

template <class T> LaneTask<T> LanePromise<T>::get_return_object() {
  return LaneTask<T>(std::coroutine_handle<LanePromise>::from_promise(*this));
}
inline LaneTask<void> LanePromise<void>::get_return_object() {
  return LaneTask<void>(std::coroutine_handle<LanePromise>::from_promise(*this));
}

}  // namespace graze
