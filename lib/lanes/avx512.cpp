// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/carry.hpp>

void graze::lanes::carry_avx512(const Job& job) { carry<xsimd::batch<double, xsimd::avx512f>>(job); }
void graze::lanes::contacts_avx512(const ContactJob& job) { pass_contacts<xsimd::batch<double, xsimd::avx512f>>(job); }
