// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against, and enough behind it to run in a test.
package com.google.ar.core;

public class Pose {
  private final float[] translation, rotation;
  public Pose(float[] translation, float[] rotation) {
    this.translation = translation;
    this.rotation = rotation;
  }
  public float[] getRotationQuaternion() { return rotation; }
  public float[] getTranslation() { return translation; }
}
