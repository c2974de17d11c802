// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against.
package com.google.ar.core;

public class CameraIntrinsics {
  public float[] getFocalLength() { return null; }
  public float[] getPrincipalPoint() { return null; }
  public int[] getImageDimensions() { return null; }
}
