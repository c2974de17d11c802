// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2;

public class CameraCharacteristics {
  public static class Key<T> {}
  public static final int LENS_FACING_BACK = 1;
  public static final Key<Integer> LENS_FACING = null, SENSOR_ORIENTATION = null;
  public static final Key<float[]> LENS_INTRINSIC_CALIBRATION = null, LENS_DISTORTION = null;
  public static final Key<android.graphics.Rect> SENSOR_INFO_PRE_CORRECTION_ACTIVE_ARRAY_SIZE = null;
  public static final Key<android.hardware.camera2.params.StreamConfigurationMap> SCALER_STREAM_CONFIGURATION_MAP = null;
  public <T> T get(Key<T> key) { return null; }
}
