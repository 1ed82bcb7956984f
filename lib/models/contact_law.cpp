// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/models/contact_law.hpp>

#include <graze/lib/models/laws.hpp>

#include <stdexcept>

namespace graze {

const std::vector<ContactLaw>& contact_laws() {
  static const std::vector<ContactLaw> list = {hertz_law(), linear_elastic_law(), newton_law()};
  return list;
}

const ContactLaw& contact_law(std::string_view name) {
  std::vector<std::string> names;
  for (const ContactLaw& law : contact_laws()) {
    if (law.name == name) return law;
    names.push_back(law.name);
  }
  throw std::invalid_argument(unknown_name("contact law", name, names));
}

}  // namespace graze
