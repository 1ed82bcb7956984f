// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::fused::carry_eight(const Job& job) { carry<xsimd::batch<double, xsimd::avx512f>>(job); }
void graze::lanes::fused::contacts_eight(const ContactJob& job) { pass_contacts<xsimd::batch<double, xsimd::avx512f>>(job); }
