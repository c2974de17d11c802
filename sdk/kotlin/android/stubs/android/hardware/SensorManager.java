// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware;

public class SensorManager {
  public static final int SENSOR_DELAY_GAME = 1;
  public Sensor getDefaultSensor(int type) { return null; }
  public boolean registerListener(SensorEventListener listener, Sensor sensor, int period) { return false; }
  public void unregisterListener(SensorEventListener listener) {}
}
