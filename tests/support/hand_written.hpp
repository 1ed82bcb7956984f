// SPDX-License-Identifier: GPL-3.0-or-later
// The built-in oscillators with functions and derivatives written by hand in C++. They are the reference for the built-in
// systems, which are made from text, and for the recognised structure.
#pragma once

#include <graze/lib/models/oscillator.hpp>

namespace graze::support {

/// The system of make_oscillator, for the laws "hertz", "linear" and "newton".
HybridSystem hand_written_oscillator(const OscillatorKind& kind, const ContactLaw& law);

}  // namespace graze::support
