// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.content;

public class Context {
  public static final String CAMERA_SERVICE = "camera", SENSOR_SERVICE = "sensor";
  public Object getSystemService(String name) { return null; }
}
