// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/map/map_message.hpp>
#include <graze/apps/map/map_run.hpp>
#include <graze/apps/map/map_threads.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <thread>

namespace graze::apps {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds nap{2};
constexpr milliseconds heartbeat{5000};
constexpr double silence = 120.0;  // seconds without a message

constexpr const char* no_message = "rank {} sent an invalid message; start all ranks with the same graze";

/// The work of rank 0.
class Master {
 public:
  Master(MapStore& store, const Json& head, Ranks& ranks, int threads, const Console& console)
      : store_(store), ranks_(ranks), todo_(store.missing()), threads_(store.plan(), store.fingerprint(), threads),
        quiet_for_(static_cast<std::size_t>(ranks.count()), 0.0), progress_(console.err, console.quiet, "mapping") {
    Json plan = head;
    plan["chunk_rows"] = store.plan().chunk_rows;
    plan["fingerprint"] = store.fingerprint();
    for (int rank = 1; rank < ranks.count(); ++rank) ranks.send(rank, map_message('P', flat(plan)));
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
      if (!busy) threads_.wait(nap);
    }
    if (out_.message.empty()) out_.status = Status::done;
    threads_.stop();
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
        ranks_.send(wanting_.front(), map_message('C', todo_[next_++]));
        wanting_.pop_front();
      } else if (threads_.wants_more()) {
        threads_.give(todo_[next_++]);
      } else {
        return;
      }
    }
    if (closed_) return;
    closed_ = true;
    threads_.close();
    for (int rank = 1; rank < ranks_.count(); ++rank) ranks_.send(rank, "N");
  }

  /// Stores the finished chunks of this rank; false: there were none.
  bool take_finished() {
    bool any = false;
    try {
      for (; const auto chunk = threads_.take(); any = true) keep(chunk->number, chunk->bytes);
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

  void hear(const Message& heard) {
    const int rank = heard.from;
    quiet_for_[static_cast<std::size_t>(rank)] = 0.0;
    const std::optional<MapMessage> message = message_from(heard.text);
    if (!message) return fail(fmt::format(no_message, rank));
    switch (message->letter) {
    case 'W':
      wanting_.push_back(rank);
      break;
    case 'D':
      if (!chunk_from(message->rest, store_.plan(), store_.fingerprint(), message->number))
        fail(fmt::format("chunk {} came damaged from rank {}", message->number, rank));
      else
        keep(message->number, std::string(message->rest));
      break;
    case 'F':
      fail(fmt::format("rank {}: {}", rank, message->rest));
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
        ranks_.count() > 1 ? static_cast<double>(finished) / chunks : (before + static_cast<double>(threads_.points())) / points;
    progress_.update(share, [&] { return fmt::format("{} of {} chunks, {:.0f} points in all", finished, chunks, points); });
  }

  MapStore& store_;
  Ranks& ranks_;
  std::vector<int> todo_;
  std::size_t next_ = 0;
  MapThreads threads_;
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
    threads_.emplace(plan_, head.at("fingerprint").get<std::uint64_t>(), threads);
  }

  /// Runs until rank 0 sends the end.
  void run() {
    Clock::time_point last_sign = Clock::now();
    for (bool reported = false, asked = false;;) {
      while (auto chunk = threads_->take()) ranks_.send(0, map_message('D', chunk->number, chunk->bytes));
      if (!asked && threads_->wants_more()) {
        asked = true;
        ranks_.send(0, "W");
      }
      while (const auto heard = ranks_.receive()) {
        const std::optional<MapMessage> message = message_from(heard->text);
        if (!message || message->number >= plan_.chunks()) throw std::invalid_argument(fmt::format(no_message, heard->from));
        if (message->letter == 'E') return;
        if (message->letter == 'C') {
          threads_->give(message->number);
          asked = false;
        }
        if (message->letter == 'N') threads_->close();
      }
      if (interruptions() > 0 && !reported) {  // rank 0 watches the time limit
        reported = true;
        ranks_.send(0, "Fended by a signal");
      }
      if (Clock::now() - last_sign > heartbeat) {
        last_sign = Clock::now();
        ranks_.send(0, "H");
      }
      threads_->wait(nap);
    }
  }

 private:
  Ranks& ranks_;
  MapPlan plan_;
  std::optional<MapThreads> threads_;
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
      const std::optional<MapMessage> plan = message_from(first.text);
      if (!plan || plan->letter != 'P') throw std::invalid_argument(fmt::format(no_message, first.from));
      Helper(ranks, parse_json(std::string(plan->rest)), threads).run();
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
