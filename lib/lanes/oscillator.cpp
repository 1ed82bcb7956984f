// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/oscillator.hpp>

#include <graze/lib/flow/cubic_flow.hpp>
#include <graze/lib/flow/linear_flow.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

namespace graze::lanes {

namespace {

/// x'' + 2 damping x' + stiffness x + beta x^3 = amplitude cos(frequency t) + constant.
struct Flight {
  double damping, stiffness, beta, amplitude, frequency, constant;
  bool cubic;  ///< has a cubic spring, even if beta is 0
};

/// The flight of a mode; nullopt: it has another equation.
std::optional<Flight> flight_of(const ModeStructure& structure) {
  if (const auto* q = std::get_if<LinearOscillator>(&structure))
    return Flight{q->damping, q->stiffness, 0.0, q->amplitude, q->frequency, q->constant, false};
  using C = CubicOscillator;
  if (const auto* one = std::get_if<C>(&structure)) {
    const auto& q = one->value;
    return Flight{q[C::damping], q[C::stiffness], q[C::cubic], q[C::amplitude], q[C::frequency], q[C::constant], true};
  }
  return std::nullopt;
}

/// Number of cells of a forcing period.
double cells_of(const Flight& free) {
  const double w = free.frequency;
  return std::ceil(2.0 * std::numbers::pi / w * std::max(w, std::sqrt(free.stiffness)) / widest_cell);
}

struct Description {
  Flight free;
  Law law = Law::restitution;
  double barrier = 0.0, restitution = 1.0;
  HertzContact hertz = {};
  Flight pressed = {};  ///< of -x, against a linear elastic stop
  std::size_t hit = 0;
};

const Event* only_event(const HybridSystem& system, std::size_t mode) {
  const Event* found = nullptr;
  for (const Event& event : system.events) {
    if (event.from != mode) continue;
    if (found) return nullptr;
    found = &event;
  }
  return found;
}

ModeStructure structure(const HybridSystem& system, std::size_t mode, const Vector& p) {
  return system.modes[mode].structure ? system.modes[mode].structure(p) : ModeStructure{};
}

/// Whether a contact is left at the level where it was entered, with continuous state and field.
bool leads_back(const Event& entering, const Event& leaving) {
  return leaving.to == entering.from && leaving.continuous && entering.continuous && leaving.guard.level &&
         leaving.guard.level->level == entering.guard.level->level;
}

/// Largest dampings (k_H b_H and b). Beyond them a contact creeps so slowly that its tangent in Hill's form
/// (contact_series.hpp), a difference of their squares there, loses digits.
constexpr double strongest_contact_damping = 3e4, strongest_damping = 30.0;

/// Whether the contact follows Hertz's law and the oscillator is that of the flight.
bool is_contact_of(const Flight& free, const HertzContact& contact, const Event& entering) {
  using C = HertzContact;
  const auto& q = contact.value;
  return q[C::damping] == free.damping && q[C::amplitude] == free.amplitude && q[C::frequency] == free.frequency &&
         q[C::beta] == free.beta && free.stiffness == 1.0 && free.constant == 0.0 &&
         is_barrier(contact, entering.guard.level->level);
}

/// Largest relative difference between 2 pi / frequency and a period given as an expression of parameters: rounding.
constexpr double roundings_of_period = 4e-16;

/// Whether the lanes support the flight.
bool flies(const HybridSystem& system, std::size_t mode, const ModeStructure& structure, const Flight& flight, const Vector& p) {
  const double T = forcing_period(system, p), own = 2.0 * std::numbers::pi / flight.frequency;
  if (std::abs(own - T) > roundings_of_period * T) return false;
  if (flight.cubic) return CubicFlow::applies(system, mode);
  return LinearFlow::applies(system, mode, {}, std::get<LinearOscillator>(structure)) &&
         flight.stiffness > flight.damping * flight.damping && cells_of(flight) <= most_cells;
}

/// The same motion as seen from the other side of the barrier.
Flight mirrored(Flight flight) {
  flight.amplitude = -flight.amplitude;
  flight.constant = -flight.constant;
  return flight;
}

std::optional<Description> describe(const HybridSystem& system, const Vector& p) {
  if (system.states != 2 || !is_forced(system) || system.modes.empty()) return std::nullopt;
  constexpr std::size_t free_mode = 0;
  const ModeStructure free_structure = structure(system, free_mode, p);
  const std::optional<Flight> free = flight_of(free_structure);
  const Event* hit = only_event(system, free_mode);
  if (!free || !hit || !hit->guard.level || hit->guard.level->coordinate != 0 || hit->guard.level->sign < 0.0)
    return std::nullopt;
  if (!flies(system, free_mode, free_structure, *free, p)) return std::nullopt;
  Description out{*free};
  out.hit = static_cast<std::size_t>(hit - system.events.data());
  out.barrier = p[static_cast<Eigen::Index>(hit->guard.level->level)];
  if (hit->reset.rebound && hit->to == free_mode) {
    out.restitution = p[static_cast<Eigen::Index>(hit->reset.rebound->coefficient)];
    return out;
  }
  const ModeStructure pressed = structure(system, hit->to, p);
  const Event* leaving = only_event(system, hit->to);
  if (!leaving || hit->reset.map || leaving->reset.map || !leads_back(*hit, *leaving)) return std::nullopt;
  if (const auto* contact = std::get_if<HertzContact>(&pressed)) {
    if (!is_contact_of(*free, *contact, *hit)) return std::nullopt;
    const auto& q = contact->value;
    if (q[HertzContact::stiffness] * q[HertzContact::contact_damping] > strongest_contact_damping ||
        q[HertzContact::damping] > strongest_damping)
      return std::nullopt;
    out.law = Law::hertz;
    out.hertz = *contact;
    return out;
  }
  const std::optional<Flight> contact = flight_of(pressed);
  if (!contact || contact->cubic != free->cubic || !flies(system, hit->to, pressed, *contact, p)) return std::nullopt;
  out.law = Law::linear_elastic;
  out.pressed = mirrored(*contact);
  return out;
}

/// Adds the coefficients of a linear flight's closed form and of its grid.
void add_closed_form(const Flight& free, Coefficients& q) {
  const double w = free.frequency, k = free.stiffness, b = free.damping;
  const double detuning = k - w * w, drag = 2.0 * b * w, D = detuning * detuning + drag * drag;
  q[rate] = std::sqrt(k - b * b);
  q[cosine] = free.amplitude == 0.0 ? 0.0 : free.amplitude * detuning / D;
  q[sine] = free.amplitude == 0.0 ? 0.0 : free.amplitude * drag / D;
  q[offset] = free.constant / k;
  q[root_k] = std::sqrt(k);
  q[inverse_rate] = 1.0 / q[rate];
  const double forced = std::hypot(q[cosine], q[sine]);
  q[forced1] = forced * w;
  q[forced6] = forced * std::pow(w, 6);
  q[cells] = cells_of(free);
  q[cell] = q[period] / q[cells];
  q[inverse_cell] = q[cells] / q[period];
  const double h = q[cell], fall = std::exp(-b * h), turned_c = std::cos(w * h), turned_s = std::sin(w * h);
  q[cell_p] = fall * std::cos(q[rate] * h);
  q[cell_q] = fall * std::sin(q[rate] * h);
  q[cell_c] = q[cosine] * turned_c + q[sine] * turned_s;
  q[cell_s] = q[sine] * turned_c - q[cosine] * turned_s;
}

/// Stiffness of a flight linearised at x: the square of the angular frequency there.
double stiffness_at(const Flight& flight, double x) { return flight.stiffness + 3.0 * flight.beta * x * x; }

/// Coefficients of x (side 1), or of -x (side -1).
Coefficients coefficients_of(const Description& oscillator, double of_side) {
  const Flight& free = of_side > 0.0 ? oscillator.free : oscillator.pressed;
  Coefficients q{};
  q[damping] = free.damping;
  q[stiffness] = free.stiffness;
  q[cubic] = free.beta;
  q[frequency] = free.frequency;
  q[amplitude] = free.amplitude;
  q[constant] = free.constant;
  q[barrier] = of_side * oscillator.barrier;
  q[side] = of_side;
  q[period] = 2.0 * std::numbers::pi / free.frequency;
  // The time of impact has error (position rounding) / (impact speed). The tangent of a linear elastic stop, whose field bends
  // at the barrier by its stiffness, has k_S times that error.
  const double corner = oscillator.law == Law::linear_elastic ? std::sqrt(oscillator.pressed.stiffness) : 0.0;
  q[slowest_impact] = 1e-4 * std::max(1.0, 0.005 * (1.0 + std::abs(oscillator.barrier)) * corner);
  q[shortest_flight] = 0.06 / std::sqrt(std::max(1e-6, stiffness_at(free, oscillator.barrier)));
  q[restitution] = oscillator.restitution;
  q[rebound_volume] = oscillator.law == Law::restitution ? 2.0 * std::log(oscillator.restitution) : 0.0;
  q[contact_stiffness] = oscillator.hertz.value[HertzContact::stiffness];
  q[contact_damping] = oscillator.hertz.value[HertzContact::contact_damping];
  if (!free.cubic) add_closed_form(free, q);
  return q;
}

using Complex = std::complex<long double>;  // so that a double is right to its last bit

/// z^k for k = 0, 1, ..., each from two earlier powers, so that few products follow on each other.
std::vector<Complex> powers(Complex z, std::size_t count) {
  std::vector<Complex> out{1.0L, z};
  out.reserve(count + 1);
  for (std::size_t k = 2; k < count; ++k) {
    const Complex a = out[k / 2], b = out[k - k / 2];
    out.emplace_back(a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real());
  }
  return out;
}

Complex polar(long double size, long double angle) { return {size * std::cos(angle), size * std::sin(angle)}; }

/// Cosine and sine of k/n of a turn, k = 0 ... n + 1.
struct Phases {
  std::vector<double> c, s;
};
/// The phases for n cells. Many parameter sets share them: the last ones are kept.
std::shared_ptr<const Phases> phases_of(std::size_t n) {
  thread_local std::shared_ptr<const Phases> last;
  if (last && last->c.size() == n + 2) return last;
  auto phases = powers(polar(1.0L, 2.0L * std::numbers::pi_v<long double> / static_cast<long double>(n)), n);
  phases.emplace_back(1.0L);
  phases.push_back(phases[1]);
  const auto made = std::make_shared<Phases>();
  for (const Complex& z : phases) {
    made->c.push_back(static_cast<double>(z.real()));
    made->s.push_back(static_cast<double>(z.imag()));
  }
  return last = made;
}

std::shared_ptr<const Grid> grid_of(const Coefficients& q) {
  struct Values {
    Grid grid;
    std::vector<double> forced;
    std::shared_ptr<const Phases> phases;
  };
  const auto values = std::make_shared<Values>();
  Grid& grid = values->grid;
  const long double h = q[cell];
  const auto turns = powers(polar(std::exp(-q[damping] * h), q[rate] * h), points_ahead);
  for (std::size_t i = 0; i < points_ahead; ++i) {
    grid.turn_c[i] = static_cast<double>(turns[i].real());
    grid.turn_s[i] = static_cast<double>(turns[i].imag());
  }
  const auto n = static_cast<std::size_t>(q[cells]);
  values->phases = phases_of(n);
  const auto& [c, s] = *values->phases;
  values->forced.resize(n + 1 + points_ahead, std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k <= n; ++k) values->forced[k] = q[cosine] * c[k] + q[sine] * s[k] + q[offset];
  grid.forced = values->forced.data();
  grid.phase_c = c.data();
  grid.phase_s = s.data();
  return {values, &grid};
}

}  // namespace

bool lanes_support(const HybridSystem& system, const Vector& p) { return describe(system, p).has_value(); }

std::optional<Oscillator> lane_oscillator(const HybridSystem& system, const Vector& p) {
  const std::optional<Description> description = describe(system, p);
  if (!description) return std::nullopt;
  Oscillator out;
  out.law = description->law;
  out.hit = description->hit;
  out.cubic = description->free.cubic;
  out.coefficients = coefficients_of(*description, 1.0);
  if (!out.cubic) out.grid = grid_of(out.coefficients);
  if (out.law != Law::linear_elastic) return out;
  out.pressed = coefficients_of(*description, -1.0);
  if (!out.cubic) out.pressed_grid = grid_of(out.pressed);
  return out;
}

}  // namespace graze::lanes
