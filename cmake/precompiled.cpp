// SPDX-License-Identifier: Apache-2.0
// The precompiled header of this file is that of all libraries.
