// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::fused::carry_two(const Job& job) { carry<xsimd::batch<double, xsimd::sse4_2>>(job); }
void graze::lanes::fused::contacts_two(const ContactJob& job) { pass_contacts<xsimd::batch<double, xsimd::sse4_2>>(job); }
