// SPDX-License-Identifier: GPL-3.0-or-later
// MotionTask: a computation that suspends when it needs forcing periods carried (TaskPool), and resumes when they are. It is a
// coroutine, written as if its motion were alone; one MotionTask may await another.
#pragma once

#include <coroutine>
#include <exception>
#include <optional>
#include <utility>

namespace graze {

template <class T = void> class MotionTask;

/// Common part of the promises: the exception, and the coroutine that awaits the task.
struct TaskPromiseBase {
  std::exception_ptr error;
  std::coroutine_handle<> waiting = std::noop_coroutine();  ///< resumed when the task ends

  struct ResumeWaiting {
    bool await_ready() const noexcept { return false; }
    template <class Promise> std::coroutine_handle<> await_suspend(std::coroutine_handle<Promise> ended) const noexcept {
      return ended.promise().waiting;
    }
    void await_resume() const noexcept {}
  };
  std::suspend_always initial_suspend() const noexcept { return {}; }
  ResumeWaiting final_suspend() const noexcept { return {}; }
  void unhandled_exception() { error = std::current_exception(); }
};

template <class T> struct TaskPromise : TaskPromiseBase {
  std::optional<T> value;
  MotionTask<T> get_return_object();
  void return_value(T result) { value = std::move(result); }
  T result() {
    if (error) std::rethrow_exception(error);
    return std::move(*value);
  }
};

template <> struct TaskPromise<void> : TaskPromiseBase {
  MotionTask<void> get_return_object();
  void return_void() const {}
  void result() const {
    if (error) std::rethrow_exception(error);
  }
};

/// Arguments passed by reference must outlive the task. (g++ 12 destroys an aggregate twice if it is created among the
/// arguments of an awaited call, f({a, b}): give it a name.)
template <class T> class [[nodiscard]] MotionTask {
 public:
  using promise_type = TaskPromise<T>;
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

  /// Runs from the beginning to the first suspension.
  void begin() { handle_.resume(); }
  bool ended() const { return handle_.done(); }
  /// The result of a task that has ended. @throws the exception that ended it.
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

template <class T> MotionTask<T> TaskPromise<T>::get_return_object() {
  return MotionTask<T>(std::coroutine_handle<TaskPromise>::from_promise(*this));
}
inline MotionTask<void> TaskPromise<void>::get_return_object() {
  return MotionTask<void>(std::coroutine_handle<TaskPromise>::from_promise(*this));
}

}  // namespace graze
