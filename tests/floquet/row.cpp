// SPDX-License-Identifier: GPL-3.0-or-later
// Speculative rows: the start of each point, points that are rolled back or committed, and stretches that begin with a guess.
#include <graze/floquet/follow/row.hpp>

#include <catch2/catch.hpp>

#include <deque>
#include <memory>
#include <stdexcept>
#include <vector>

using namespace graze;

namespace {

Vector at(double x) { return Vector{{x, 0.0}}; }

/// A row whose points are given by the test.
class GivenChain : public RowChain {
 public:
  GivenChain(std::size_t size, std::size_t stretch, std::size_t many, bool predicts)
      : size_(size), stretch_(stretch), many_(many), predicts_(predicts) {}
  std::size_t size() const override { return size_; }
  std::size_t stretch() const override { return stretch_; }
  std::size_t many() const override { return many_; }
  bool predicts() const override { return predicts_; }
  MotionTask<Found> find(TaskSlot&, Begin, std::function<bool()>, std::function<void(const Vector&)>) const override {
    throw std::logic_error("a row does not compute");
  }

 private:
  std::size_t size_, stretch_, many_;
  bool predicts_;
};

enum class Ends { on_orbit, in_chaos, nowhere, failed };

/// An orbit of period 1 at state x, chaos that has reached x, a motion that is lost, or a point that could not be computed.
RowChain::Found found(Ends ends, double x = 0.0) {
  RowChain::Found out;
  out.failed = ends == Ends::failed;
  out.revokes = ends == Ends::on_orbit || ends == Ends::nowhere;
  if (ends == Ends::nowhere || ends == Ends::failed) return out;
  out.point.end = at(x);
  out.point.attractor.state = at(x);
  if (ends == Ends::in_chaos) {
    out.point.attractor.type = AttractorType::chaotic;
    return out;
  }
  out.point.attractor.type = AttractorType::periodic;
  out.point.attractor.period = 1;
  out.point.states = {at(x)};
  return out;
}

struct Rows {
  explicit Rows(std::size_t size, std::size_t stretch = 100, std::size_t many = 4, bool predicts = false)
      : chain(new GivenChain(size, stretch, many, predicts)), row(std::unique_ptr<const RowChain>(chain),
                                                                  {[this](std::size_t number, const RowPoint& point) {
                                                                     REQUIRE(number == committed.size());  // in order, each once
                                                                     committed.push_back(point);
                                                                   },
                                                                   {}},
                                                                  2) {}

  std::shared_ptr<Row::Entry> begin() {
    const auto stretch = row.stretch_to_continue();
    REQUIRE(stretch);
    return row.start(*stretch);
  }
  /// Starts the next point, which publishes x: the point after it may begin.
  std::shared_ptr<Row::Entry> published(double x) {
    const auto entry = begin();
    row.publish(*entry, at(x));
    return entry;
  }
  double x(std::size_t number) const { return committed[number].end[0]; }

  std::deque<RowPoint> committed;
  GivenChain* chain;
  Row row;
};

/// Four points: two published, the third begun.
struct ThreeBegun : Rows {
  ThreeBegun() : Rows(4) {}
  std::shared_ptr<Row::Entry> first = published(0.5), second = published(0.6), third = begin();
};

using Next = Row::Next;

}  // namespace

TEST_CASE("row: each point begins from the end of the one before") {
  Rows rows(3);
  for (std::size_t k = 0; k < 3; ++k) {
    REQUIRE(rows.row.next() == Next::likely);
    const auto entry = rows.begin();
    CHECK(rows.row.next() == Next::none);
    CHECK(entry->begin.number == k);
    REQUIRE((entry->begin.state.size() > 0) == (k > 0));
    if (k > 0) CHECK(entry->begin.state[0] == static_cast<double>(k - 1));
    CHECK_FALSE(rows.row.finished());
    rows.row.finish(*entry, found(Ends::on_orbit, static_cast<double>(k)));
    CHECK(rows.committed.size() == k + 1);
  }
  CHECK(rows.row.finished());
  CHECK(rows.row.next() == Next::none);
}

TEST_CASE("row: after a published point the next begins at once and stays if the point is chaotic") {
  Rows rows(3);
  const auto first = rows.published(0.5);
  REQUIRE(rows.row.next() == Next::likely);
  const auto second = rows.begin();
  CHECK(second->begin.state[0] == 0.5);
  CHECK_FALSE(second->begin.settled);
  rows.row.finish(*second, found(Ends::on_orbit, 2.0));
  CHECK(rows.committed.empty());  // the first might roll it back
  const auto third = rows.begin();
  CHECK(third->begin.state[0] == 2.0);
  CHECK(third->begin.settled);
  rows.row.finish(*first, found(Ends::in_chaos, 1.0));
  CHECK(rows.committed.size() == 2);
  CHECK_FALSE(second->dropped);
  rows.row.finish(*third, found(Ends::on_orbit));
  CHECK(rows.row.finished());
  CHECK(rows.x(0) == 1.0);
  CHECK(rows.x(1) == 2.0);
}

TEST_CASE_METHOD(ThreeBegun, "row: an orbit or a lost motion rolls back the points begun from the published state") {
  row.finish(*third, found(Ends::in_chaos));
  CHECK(row.done() == 1);
  const Ends ends = GENERATE(Ends::on_orbit, Ends::nowhere);
  row.finish(*first, found(ends, 7.0));
  CHECK(committed.size() == 1);
  CHECK(second->dropped);
  CHECK(third->dropped);
  CHECK(row.done() == 1);
  row.publish(*second, at(9.0));  // too late
  row.finish(*second, found(Ends::on_orbit, 9.0));
  CHECK(committed.size() == 1);
  const auto anew = begin();
  CHECK(anew->begin.number == 1);
  REQUIRE((anew->begin.state.size() > 0) == (ends == Ends::on_orbit));
  if (ends == Ends::on_orbit) CHECK(anew->begin.state[0] == 7.0);
}

TEST_CASE("row: the more points are open the less likely is the next to be kept") {
  Rows rows(20);
  std::vector<std::shared_ptr<Row::Entry>> entries;
  while (rows.row.next() == Next::likely) entries.push_back(rows.published(0.0));
  CHECK(entries.size() == 5);
  CHECK(rows.row.next() == Next::unlikely);
  rows.row.finish(*entries[0], found(Ends::in_chaos));
  CHECK(rows.row.next() == Next::likely);
}

TEST_CASE_METHOD(ThreeBegun, "row: a failed point ends the row") {
  row.finish(*third, found(Ends::on_orbit));
  row.finish(*second, found(Ends::failed));
  CHECK(third->dropped);
  CHECK(row.next() == Next::none);
  CHECK_FALSE(row.finished());
  row.finish(*first, found(Ends::in_chaos));
  CHECK(row.finished());
  CHECK(committed.size() == 1);
}

TEST_CASE("row: stretches begin with guesses, which are kept where they are on the attractor before them") {
  Rows rows(6, 2);
  const auto first = rows.begin();
  REQUIRE(rows.row.next() == Next::guess);
  const auto guess = rows.row.start_guess(), farther = rows.row.start_guess();
  CHECK(rows.row.next() == Next::none);  // two guesses are unconfirmed
  CHECK(guess->begin.number == 1);
  CHECK(guess->begin.state.size() == 0);
  CHECK(guess->begin.compared);
  CHECK_FALSE(first->begin.compared);
  rows.row.finish(*guess, found(Ends::on_orbit, 1.0));
  REQUIRE(rows.row.next() == Next::likely);
  const auto third = rows.begin();
  CHECK(third->begin.number == 2);
  CHECK(third->begin.state[0] == 1.0);
  rows.row.finish(*third, found(Ends::on_orbit, 2.0));
  rows.row.finish(*first, found(Ends::on_orbit, 0.0));
  CHECK(rows.committed.size() == 1);  // the third might still begin elsewhere
  const auto second = rows.begin();
  CHECK(second->begin.number == 1);
  CHECK(second->begin.compared);
  SECTION("on the attractor of the guess") {
    rows.row.finish(*second, found(Ends::on_orbit, 1.0 + 1e-12));
    CHECK_FALSE(third->dropped);
    CHECK(rows.committed.size() == 3);
    CHECK(rows.x(2) == 2.0);
  }
  SECTION("on another attractor") {
    rows.row.finish(*second, found(Ends::on_orbit, 5.0));
    CHECK(third->dropped);
    CHECK(rows.committed.size() == 2);
    const auto anew = rows.begin();
    CHECK(anew->begin.number == 2);
    CHECK(anew->begin.state[0] == 5.0);
    rows.row.finish(*anew, found(Ends::on_orbit, 6.0));
    CHECK(rows.committed.size() == 3);
    // After a wrong guess, the points behind an unconfirmed one are unlikely to be kept.
    rows.row.finish(*farther, found(Ends::on_orbit, 3.0));
    const auto fourth = rows.begin();
    CHECK(fourth->begin.number == 3);
    CHECK(rows.row.next() == Next::unlikely);
  }
  SECTION("nowhere: the row ends, and what was guessed is dropped") {
    rows.row.finish(*second, found(Ends::failed));
    CHECK(rows.row.finished());
    CHECK(third->dropped);
    CHECK(farther->dropped);
    CHECK(rows.committed.size() == 1);
  }
}

TEST_CASE("row: a stretch without a guess waits for the one before it") {
  Rows rows(4, 2);
  const auto first = rows.begin();
  const auto guess = rows.row.start_guess();
  rows.row.finish(*guess, found(Ends::failed));
  rows.row.finish(*first, found(Ends::on_orbit, 0.0));
  const auto second = rows.begin();
  REQUIRE(second->begin.number == 1);
  CHECK(rows.row.next() == Next::none);
  rows.row.finish(*second, found(Ends::on_orbit, 1.0));
  const auto third = rows.begin();
  CHECK(third->begin.number == 2);
  CHECK(third->begin.state[0] == 1.0);
}

TEST_CASE("row: known points are kept, and the last stretch of them is compared with its guess as in one run") {
  std::vector<RowPoint> known;
  for (int k = 0; k < 4; ++k) known.push_back(found(Ends::on_orbit, k).point);
  std::vector<std::size_t> committed;
  Row row(std::make_unique<GivenChain>(6, 2, 4, false),
          {[&committed](std::size_t number, const RowPoint&) { committed.push_back(number); }, {}}, 2, known);
  CHECK(row.done() == 4);
  REQUIRE(row.next() == Next::guess);
  const auto guess = row.start_guess();
  CHECK(guess->begin.number == 3);
  row.finish(*guess, found(Ends::on_orbit, 3.0));
  const auto stretch = row.stretch_to_continue();
  REQUIRE(stretch);
  const auto fifth = row.start(*stretch);
  CHECK(fifth->begin.number == 4);
  row.finish(*fifth, found(Ends::on_orbit, 4.0));
  CHECK(committed == std::vector<std::size_t>{4});
}

TEST_CASE("row: predicted orbits are points that are done when they start") {
  Rows rows(40, 32, 4, true);
  const auto stretch = rows.row.stretch_to_continue();
  REQUIRE(rows.row.needs_prediction(*stretch));
  CHECK(rows.row.orbits_before(*stretch).empty());
  stretch->predicted_block = 0;
  for (int k = 0; k < 16; ++k) {
    CHECK_FALSE(rows.row.needs_prediction(*stretch));
    const auto entry = rows.row.start(*stretch);
    CHECK_FALSE(entry->done);
    rows.row.finish(*entry, found(k == 13 ? Ends::in_chaos : Ends::on_orbit, k));
  }
  REQUIRE(rows.row.needs_prediction(*stretch));
  const auto before = rows.row.orbits_before(*stretch);  // back to the chaotic point
  REQUIRE(before.size() == 2);
  CHECK(before.back().front()[0] == 15.0);
  PredictedOrbit orbit;
  orbit.orbit.period = 1;
  orbit.orbit.states = {at(16.0)};
  stretch->predicted_block = 16;
  stretch->predicted_orbits = {orbit};
  const auto predicted = rows.row.start(*stretch);
  CHECK(predicted->done);
  CHECK(rows.x(16) == 16.0);
  CHECK_FALSE(rows.row.start(*stretch)->done);  // only one was found
}
