// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::carry_generic(const Job& job) { carry<xsimd::batch<double>>(job); }
void graze::lanes::contacts_generic(const ContactJob& job) { pass_contacts<xsimd::batch<double>>(job); }
