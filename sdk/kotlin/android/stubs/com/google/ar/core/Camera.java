// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against.
package com.google.ar.core;

public class Camera {
  public Pose getPose() { return null; }
  public TrackingState getTrackingState() { return TrackingState.STOPPED; }
  public CameraIntrinsics getTextureIntrinsics() { return null; }
}
