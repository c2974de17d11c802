// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware;

public interface SensorEventListener {
  void onSensorChanged(SensorEvent event);
  void onAccuracyChanged(Sensor sensor, int accuracy);
}
