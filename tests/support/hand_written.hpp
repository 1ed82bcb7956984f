// SPDX-License-Identifier: GPL-3.0-or-later
// The built-in oscillators once more, with functions and derivatives written by hand in C++: an oracle for the text they are made
// from, and for the structure that is recognised in it.
#pragma once

#include <graze/lib/models/oscillator.hpp>

namespace graze::support {

/// What make_oscillator makes, for the laws "hertz", "linear" and "newton".
HybridSystem hand_written_oscillator(const OscillatorKind& kind, const ContactLaw& law);

}  // namespace graze::support
