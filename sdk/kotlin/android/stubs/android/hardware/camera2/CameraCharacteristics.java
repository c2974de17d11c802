// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2;

public class CameraCharacteristics {
  public static class Key<T> {}
  public static final int LENS_FACING_BACK = 1;
  public static final Key<Integer> LENS_FACING = new Key<>(), SENSOR_ORIENTATION = new Key<>();
  public static final Key<float[]> LENS_INTRINSIC_CALIBRATION = new Key<>(), LENS_DISTORTION = new Key<>();
  public static final Key<android.graphics.Rect> SENSOR_INFO_PRE_CORRECTION_ACTIVE_ARRAY_SIZE = new Key<>();
  public static final Key<android.hardware.camera2.params.StreamConfigurationMap> SCALER_STREAM_CONFIGURATION_MAP = new Key<>();
  public <T> T get(Key<T> key) { return null; }
}
