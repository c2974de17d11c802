// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against.
package com.google.ar.core;

public class Session {
  public boolean isDepthModeSupported(Config.DepthMode mode) { return false; }
}
