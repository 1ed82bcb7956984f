// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::plain::carry_one(const Job& job) { carry<double>(job); }
void graze::lanes::plain::contacts_one(const ContactJob& job) { pass_contacts<double>(job); }
