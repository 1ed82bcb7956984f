// SPDX-License-Identifier: GPL-3.0-or-later
// The contact laws, one function each, in a file of its own. contact_laws() in contact_law.cpp lists them.
#pragma once

#include <graze/lib/models/contact_law.hpp>

namespace graze {

ContactLaw hertz_law();
ContactLaw linear_elastic_law();
ContactLaw newton_law();

}  // namespace graze
