// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::plain::carry_two(const Job& job) { carry<xsimd::batch<double>>(job); }
void graze::lanes::plain::contacts_two(const ContactJob& job) { pass_contacts<xsimd::batch<double>>(job); }
