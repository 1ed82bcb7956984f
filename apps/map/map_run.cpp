// SPDX-License-Identifier: GPL-3.0-or-later
// Messages begin with a letter. From rank 0: P the plan, C a chunk to compute, N no more chunks, E end. To rank 0: W wants
// another chunk, D a finished chunk, H heartbeat, F failed, B bye (the last message).
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/map/map_run.hpp>
#include <graze/apps/map/map_threads.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace graze::apps {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds nap{2};
constexpr milliseconds heartbeat{5000};
constexpr double silence = 120.0;  // seconds without a message

std::string numbered(char letter, int number, const std::string& bytes = {}) {
  return fmt::format("{}{:08}{}", letter, number, bytes);
}

int number_of(const std::string& message) { return std::stoi(message.substr(1, 8)); }

/// The work of rank 0.
class Master {
 public:
  Master(MapStore& store, const Json& head, Ranks& ranks, int threads, const Console& console)
      : store_(store), ranks_(ranks), todo_(store.missing()), lanes_(store.plan(), store.fingerprint(), threads),
        quiet_for_(static_cast<std::size_t>(ranks.count()), 0.0), progress_(console.err, console.quiet, "mapping") {
    Json plan = head;
    plan["chunk_rows"] = store.plan().chunk_rows;
    plan["fingerprint"] = store.fingerprint();
    for (int rank = 1; rank < ranks.count(); ++rank) ranks.send(rank, "P" + flat(plan));
  }

  MapRun run() {
    Clock::time_point last = Clock::now();
    while (out_.message.empty() && store_.finished() < store_.plan().chunks()) {
      hand_out();
      bool busy = take_finished();
      while (auto message = ranks_.receive()) {
        busy = true;
        hear(*message);
      }
      if (interrupted()) {
        out_.status = Status::interrupted;
        out_.message = interruption();
        if (ranks_.count() > 1 && !is_out_of_time())
          out_.message += " by a signal (mpirun sends one if another rank has died, and says which)";
        break;
      }
      const Clock::time_point now = Clock::now();
      listen(std::chrono::duration<double>(now - last).count());
      last = now;
      report();
      if (!busy) lanes_.wait(nap);
    }
    if (out_.message.empty()) out_.status = Status::done;
    lanes_.stop();
    return out_;
  }

  /// Releases the other ranks, and keeps the chunks that they have finished meanwhile.
  void part() {
    for (int rank = 1; rank < ranks_.count(); ++rank) ranks_.send(rank, "E");
    const Clock::time_point until = Clock::now() + milliseconds(out_.status == Status::done ? 60000 : 500);
    while (byes_ + 1 < ranks_.count()) {
      while (auto message = ranks_.receive()) hear(*message);
      if (Clock::now() > until) ranks_.abort(exit_code(out_.status));
      std::this_thread::sleep_for(nap);
    }
    ranks_.finish();
  }

 private:
  void hand_out() {
    while (next_ < todo_.size()) {
      if (!wanting_.empty()) {
        ranks_.send(wanting_.front(), numbered('C', todo_[next_++]));
        wanting_.pop_front();
      } else if (lanes_.wants_more()) {
        lanes_.give(todo_[next_++]);
      } else {
        return;
      }
    }
    if (closed_) return;
    closed_ = true;
    lanes_.close();
    for (int rank = 1; rank < ranks_.count(); ++rank) ranks_.send(rank, "N");
  }

  /// Stores the finished chunks of this rank; false: there were none.
  bool take_finished() {
    bool any = false;
    try {
      for (; const auto chunk = lanes_.take(); any = true) keep(chunk->number, chunk->bytes);
    } catch (const std::runtime_error& error) {
      fail(error.what());
    }
    return any;
  }

  void keep(int number, const std::string& bytes) {
    if (auto failure = store_.keep(number, bytes)) {
      fail(*failure);
      out_.unwritable = true;
    }
  }

  void hear(const Message& message) {
    const int rank = message.from;
    quiet_for_[static_cast<std::size_t>(rank)] = 0.0;
    switch (message.text.front()) {
    case 'W':
      wanting_.push_back(rank);
      break;
    case 'D': {
      const int number = number_of(message.text);
      const std::string bytes = message.text.substr(9);
      if (!chunk_from(bytes, store_.plan(), store_.fingerprint(), number))
        fail(fmt::format("chunk {} came damaged from rank {}", number, rank));
      else
        keep(number, bytes);
      break;
    }
    case 'F':
      fail(fmt::format("rank {}: {}", rank, message.text.substr(1)));
      break;
    case 'B':
      ++byes_;
      break;
    default:  // H
      break;
    }
  }

  /// The time since the last call counts for at most one second: a process that was suspended and resumes must not blame the
  /// others.
  void listen(double seconds) {
    for (std::size_t rank = 1; rank < quiet_for_.size(); ++rank) {
      quiet_for_[rank] += std::min(seconds, 1.0);
      if (quiet_for_[rank] > silence) fail(fmt::format("rank {} has not been heard of for {} seconds", rank, silence));
    }
  }

  void fail(const std::string& message) {
    if (out_.message.empty()) out_.message = message;
  }

  void report() {
    const int chunks = store_.plan().chunks(), finished = store_.finished();
    const double points = store_.plan().points();
    // A single process counts points; for other ranks only the finished chunks are known.
    const double before = points * (chunks - static_cast<double>(todo_.size())) / chunks;
    const double share =
        ranks_.count() > 1 ? static_cast<double>(finished) / chunks : (before + static_cast<double>(lanes_.points())) / points;
    progress_.update(share, [&] { return fmt::format("{} of {} chunks, {:.0f} points in all", finished, chunks, points); });
  }

  MapStore& store_;
  Ranks& ranks_;
  std::vector<int> todo_;
  std::size_t next_ = 0;
  MapThreads lanes_;
  std::deque<int> wanting_;
  std::vector<double> quiet_for_;
  Progress progress_;
  MapRun out_;
  bool closed_ = false;
  int byes_ = 0;
};

/// The work of a rank that has received the plan.
class Helper {
 public:
  Helper(Ranks& ranks, const Json& head, int threads) : ranks_(ranks), plan_(plan_of(head)) {
    plan_.chunk_rows = head.at("chunk_rows");
    lanes_.emplace(plan_, head.at("fingerprint").get<std::uint64_t>(), threads);
  }

  /// Runs until rank 0 sends the end.
  void run() {
    Clock::time_point last_sign = Clock::now();
    for (bool told = false, asked = false;;) {
      while (auto chunk = lanes_->take()) ranks_.send(0, numbered('D', chunk->number, chunk->bytes));
      if (!asked && lanes_->wants_more()) {
        asked = true;
        ranks_.send(0, "W");
      }
      while (auto message = ranks_.receive()) {
        const char letter = message->text.front();
        if (letter == 'E') return;
        if (letter == 'C') {
          lanes_->give(number_of(message->text));
          asked = false;
        }
        if (letter == 'N') lanes_->close();
      }
      if (interruptions() > 0 && !told) {  // rank 0 watches the time limit
        told = true;
        ranks_.send(0, "Fended by a signal");
      }
      if (Clock::now() - last_sign > heartbeat) {
        last_sign = Clock::now();
        ranks_.send(0, "H");
      }
      lanes_->wait(nap);
    }
  }

 private:
  Ranks& ranks_;
  MapPlan plan_;
  std::optional<MapThreads> lanes_;
};

/// The first message from rank 0: the plan, or the end.
Message first_message(Ranks& ranks) {
  for (;;) {
    if (auto message = ranks.receive()) return *message;
    std::this_thread::sleep_for(nap);
  }
}

void await_end(Ranks& ranks) {
  while (first_message(ranks).text != "E") {
  }
}

}  // namespace

MapRun run_map(MapStore& store, const Json& head, Ranks& ranks, int threads, const Console& console,
               const std::function<bool()>& write) {
  Master master(store, head, ranks, threads, console);
  MapRun run = master.run();
  if (run.status == Status::done) run.unwritable = !write();
  // Reported before waiting for the other ranks: a launcher that ends the run may not leave much time.
  if (run.status != Status::done)
    console.err << fmt::format("graze map: {}; {} of {} chunks are finished, {}\n", run.message, store.finished(),
                               store.plan().chunks(), store.advice())
                << std::flush;
  master.part();
  return run;
}

int run_map_helper(Ranks& ranks, int threads) {
  const Message first = first_message(ranks);
  bool ended = first.text == "E";
  int code = 0;
  if (!ended) {
    try {
      Helper(ranks, Json::parse(first.text.substr(1)), threads).run();
    } catch (const std::exception& error) {
      ranks.send(0, std::string("F") + error.what());
      await_end(ranks);
      code = 1;
    }
  }
  ranks.send(0, "B");
  ranks.finish();
  return code;
}

void dismiss(Ranks& ranks) {
  for (int rank = 1; rank < ranks.count(); ++rank) ranks.send(rank, "E");
  for (int byes = 0; byes + 1 < ranks.count();) {
    const auto message = ranks.receive();
    if (!message)
      std::this_thread::sleep_for(nap);
    else if (message->text == "B")
      ++byes;
  }
  ranks.finish();
}

}  // namespace graze::apps
