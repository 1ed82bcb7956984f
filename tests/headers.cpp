// SPDX-License-Identifier: GPL-3.0-or-later
// Empty: it carries the precompiled headers of the tests.
