// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against.
package com.google.ar.core;

public class Config {
  public enum DepthMode { DISABLED, AUTOMATIC, RAW_DEPTH_ONLY }
}
