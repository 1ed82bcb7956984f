// SPDX-License-Identifier: GPL-3.0-or-later
// Empty: there for the precompiled headers of the tests.
