// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::fused::carry_four(const Job& job) { carry<xsimd::batch<double, xsimd::avx2>>(job); }
void graze::lanes::fused::contacts_four(const ContactJob& job) { pass_contacts<xsimd::batch<double, xsimd::avx2>>(job); }
