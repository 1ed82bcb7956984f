// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lane_exchange.hpp>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace graze {

namespace {

/// Members that are carried at a time: what keeps the lanes full, also where many ask for one period only.
constexpr std::size_t together = 128;
/// Periods of a turn: as many as keep so many motions busy, since all wait for the last of them, but not one by one.
constexpr std::size_t busy = 48, fewest_periods = 2, most_periods = 32;

}  // namespace

struct LanePool::Member {
  LanePlace place;
  LaneTask<> task;
};

/// A computation on its way to another pool, with its parameters.
struct LaneExchange::Parcel {
  std::unique_ptr<LanePool::Member> member;
  std::optional<ManyMotions::Taken> parameters;
};

LaneExchange::LaneExchange(std::function<void()> wake) : wake_(std::move(wake)) {}
LaneExchange::~LaneExchange() = default;

void LaneExchange::put(std::vector<Parcel> parcels) {
  {
    const std::lock_guard lock(mutex_);
    std::move(parcels.begin(), parcels.end(), std::back_inserter(parcels_));
    has_some_ = true;
  }
  wake_();
}

std::vector<LaneExchange::Parcel> LaneExchange::get() {
  const std::lock_guard lock(mutex_);
  has_some_ = false;
  return std::exchange(parcels_, {});
}

ManyMotions& LanePlace::motions() const { return pool_->motions_; }

void LanePlace::take_parameters(const Vector& p) {
  if (!own_parameters_ || p != own_) {
    if (!own_parameters_) own_parameters_ = pool_->free_place();
    if (own_parameters_)
      motions().change_parameters(*own_parameters_, p);
    else
      own_parameters_ = motions().add_parameters(p);
    own_ = p;
  }
  parameters_ = *own_parameters_;
}

LanePlace::Carrying LanePlace::carry(std::span<const MotionStart> motions, std::size_t periods, bool tangent) {
  starts_.assign(motions.begin(), motions.end());
  periods_ = periods;
  carried_ = 0;
  tangent_ = tangent;
  speeds_ = nullptr;
  results_.resize(motions.size() * periods);
  return Carrying(*this);
}

LanePlace::Carrying LanePlace::carry(const Vector& state, std::size_t periods, ImpactSpeeds* speeds) {
  const MotionStart start = at(state);
  const Carrying carrying = carry({&start, 1}, periods, false);
  speeds_ = speeds;
  return carrying;
}

/// Adds the next periods of its motions.
void LanePlace::add_runs(std::size_t periods, std::vector<MotionRun>& runs) {
  periods = std::min(periods, periods_ - carried_);
  for (std::size_t m = 0; m < starts_.size(); ++m) {
    PeriodResult* const next = &results_[m * periods_ + carried_];
    if (carried_ == 0)
      runs.push_back({{parameters_, starts_[m].x, starts_[m].v}, periods, next, speeds_});
    else if (next[-1].termination == Termination::time)
      runs.push_back({{parameters_, next[-1].x, next[-1].v}, periods, next, speeds_});
    else
      std::fill_n(next, periods, PeriodResult{.termination = next[-1].termination});
  }
  carried_ += periods;
}

/// The number of a parameter set that nobody has.
std::optional<std::size_t> LanePool::free_place() {
  if (free_parameters_.empty()) return std::nullopt;
  const std::size_t place = free_parameters_.back();
  free_parameters_.pop_back();
  return place;
}

/// For another computation.
void LanePool::clear(LanePlace& place) {
  if (place.own_parameters_) free_parameters_.push_back(*place.own_parameters_);
  place.own_parameters_.reset();
  place.hurries_ = false;
  place.results_.clear();
}

/// Every other member to a pool that has none.
void LanePool::give(std::vector<std::unique_ptr<Member>>& members) {
  std::vector<LaneExchange::Parcel> parcels;
  for (std::size_t i = 1; i < members.size(); i += 2) {
    LaneExchange::Parcel& parcel = parcels.emplace_back(std::move(members[i]));
    const std::optional<std::size_t>& own = parcel.member->place.own_parameters_;
    if (!own) continue;
    parcel.parameters = motions_.take(*own);
    free_parameters_.push_back(*own);
  }
  std::erase(members, nullptr);
  exchange_->put(std::move(parcels));
}

void LanePool::take(std::vector<std::unique_ptr<Member>>& members) {
  for (LaneExchange::Parcel& parcel : exchange_->get()) {
    LanePlace& place = parcel.member->place;
    place.pool_ = this;
    if (parcel.parameters)
      place.parameters_ = *(place.own_parameters_ = motions_.add(std::move(*parcel.parameters), free_place()));
    members.push_back(std::move(parcel.member));
  }
}

/// Those of a kind whose motions are carried next: all, but for few more than fill the lanes of a register, which are carried
/// sooner in turn than with most lanes of a second one idle.
void LanePool::choose(std::span<const std::unique_ptr<Member>> members, bool tangent) {
  chosen_.clear();
  const auto is_one = [&](const auto& member) { return member->place.tangent_ == tangent; };
  std::size_t motions = 0;
  for (const auto& member : members) motions += is_one(member) ? member->place.starts_.size() : 0;
  const std::size_t lanes = motions_.lanes(), most = motions > lanes && 8 * motions <= 14 * lanes ? lanes : motions;
  std::size_t& next = next_[tangent ? 1 : 0];
  std::size_t room = most, left_out = members.size();
  next %= members.size();
  for (const bool hurrying : {true, false})
    for (std::size_t k = 0; k < members.size(); ++k) {
      const std::size_t i = (next + k) % members.size();
      if (!is_one(members[i]) || members[i]->place.hurries_ != hurrying) continue;
      const std::size_t n = members[i]->place.starts_.size();
      if (hurrying || n <= room || room == most) {
        chosen_.push_back(members[i].get());
        room -= std::min(n, room);
      } else if (left_out == members.size()) {
        left_out = i;
      }
    }
  if (left_out < members.size()) next = left_out;
}

void LanePool::carry(std::span<const std::unique_ptr<Member>> members, bool tangent) {
  choose(members, tangent);
  // motions_left[k]: that are to be carried for so many periods more, the last: or for longer
  std::array<std::size_t, most_periods + 1> motions_left{};
  std::size_t motions = 0;
  for (const Member* const member : chosen_) {
    const LanePlace& place = member->place;
    motions_left[std::min(place.periods_ - place.carried_, most_periods)] += place.starts_.size();
    motions += place.starts_.size();
  }
  const std::size_t all = std::min(busy, motions);
  std::size_t periods = 1, work = motions, going_on = motions - motions_left[1];
  while (periods < fewest_periods || (periods < most_periods && work + going_on >= all * (periods + 1))) {
    work += going_on;
    going_on -= motions_left[++periods];
  }
  runs_.clear();
  for (Member* const member : chosen_) member->place.add_runs(periods, runs_);
  motions_.carry(runs_, tangent);
}

void LanePool::run(std::size_t count, const std::function<LaneTask<>(std::size_t, LanePlace&)>& make) {
  std::size_t begun = 0;
  run([&](LanePlace& lane, std::size_t) { return begun < count ? std::optional(make(begun++, lane)) : std::nullopt; });
}

void LanePool::run(const std::function<std::optional<LaneTask<>>(LanePlace&, std::size_t)>& next) {
  std::vector<std::unique_ptr<Member>> members, spare;
  const auto end = [&](std::unique_ptr<Member>& member) {
    member->task.result();
    member->task = {};
    clear(member->place);
    spare.push_back(std::move(member));
  };
  for (;;) {
    for (auto& member : members)
      if (member->task.ended()) end(member);
    std::erase(members, nullptr);
    if (exchange_ && members.size() > 1 && exchange_->wants()) give(members);
    while (members.size() < together) {
      if (spare.empty()) spare.push_back(std::make_unique<Member>(Member{LanePlace(*this), {}}));
      auto task = next(spare.back()->place, members.size());
      if (!task) break;
      std::unique_ptr<Member> begun = std::move(spare.back());
      spare.pop_back();
      begun->task = std::move(*task);
      begun->task.begin();
      begun->task.ended() ? end(begun) : members.push_back(std::move(begun));
    }
    if (members.empty() && exchange_) take(members);
    if (members.empty()) return;
    std::array<std::size_t, 2> motions{};  // without and with the tangent
    std::array<bool, 2> hurries{};
    for (const auto& member : members) {
      const LanePlace& place = member->place;
      motions[place.tangent_ ? 1 : 0] += place.starts_.size();
      hurries[place.tangent_ ? 1 : 0] |= place.hurries_;
    }
    // Where there are few of a kind, they wait for company.
    for (const std::size_t kind : {0, 1})
      if (hurries[kind] || motions[kind] >= std::min(busy, motions[1 - kind])) carry(members, kind == 1);
    for (const auto& member : members)
      if (member->place.carried_ == member->place.periods_) member->place.waiting_.resume();
  }
}

}  // namespace graze
